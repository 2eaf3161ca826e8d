"""Counts of clusters among which a target chooses (gpu.target): levels."""

from dataclasses import dataclass
from math import log

# Numbers of SP clusters are so far apart. Of VPL clusters they are whole words of visibility bits.
SP_STEP = 1.06
WORD, VPL_STEP = 32, 2.0**0.25
# SP clusters for each VPL cluster: as in the default counts of a GPU, and how many times that or how little of it.
SPS_PER_VPL, RANGE = 4.0, 6.0
# How little of it for a time: the fewer SP clusters there are, the more VPL clusters are near them, which are shaded
# one by one (gpu.far_light), so that shading takes hardly less and fewer VPL clusters save more.
TIME_RANGE = 2.0
# Members that a VPL cluster has on average. Those of fewer are not worth their name; those of more than a GPU's default
# counts have are shaded in their parts from afar, so that fewer of them take longer and leave no more error.
LEAST_MEMBERS, MOST_MEMBERS = 12, 48


@dataclass(frozen=True)
class Level:
    """Counts of clusters."""

    sp_clusters: int
    vpl_clusters: int

    @property
    def work(self) -> float:
        """Pairs of clusters, which most rays are in proportion to."""
        return float(self.sp_clusters) * self.vpl_clusters

    @property
    def vpls(self) -> int:
        """VPLs that they need at most."""
        return MOST_MEMBERS * self.vpl_clusters


MOST = Level(sp_clusters=131_072, vpl_clusters=16_384)


class Levels:
    """The levels of an image of so many pixels, with about `least` … `most` VPL clusters.

    below: the usual number of SP clusters over the fewest.
    """

    def __init__(self, pixels: int, least: int = WORD, most: int = MOST.vpl_clusters, *, below: float = RANGE) -> None:
        self._most, self._below = min(pixels, MOST.sp_clusters), below
        steps = range(round(log(MOST.vpl_clusters / WORD, VPL_STEP)) + 1)
        numbers = sorted({WORD * round(VPL_STEP**step) for step in steps})
        few = [number for number in numbers if number <= most] or numbers[:1]
        self.vpl_clusters = [number for number in few if number >= least] or few[-1:]
        self._of: dict[int, tuple[Level, ...]] = {}

    def usual(self, vpl_clusters: int) -> Level:
        """The level of so many VPL clusters with the usual number of SP clusters for each."""
        return Level(min(round(SPS_PER_VPL * vpl_clusters), self._most), vpl_clusters)

    def most(self, vpl_clusters: int) -> int:
        """The most SP clusters of a level with so many VPL clusters."""
        return self.of(vpl_clusters)[-1].sp_clusters

    def nearest(self, work: float) -> Level:
        """The usual level that is nearest to so much `work`."""
        return min(map(self.usual, self.vpl_clusters), key=lambda level: abs(log(level.work / work)))

    def of(self, vpl_clusters: int) -> tuple[Level, ...]:
        """All levels of so many VPL clusters, by work."""
        if vpl_clusters not in self._of:
            usual = self.usual(vpl_clusters)
            fewer, more = (int(log(times, SP_STEP)) for times in (self._below, RANGE))
            wanted = (round(usual.sp_clusters * SP_STEP**step) for step in range(-fewer, more + 1))
            counts = sorted({min(max(count, 1), self._most) for count in wanted})
            self._of[vpl_clusters] = tuple(Level(count, vpl_clusters) for count in counts)
        return self._of[vpl_clusters]


def levels_of(pixels: int, vpls: int, *, below: float = RANGE) -> Levels:
    """The levels of an image of so many pixels that is lit by so many VPLs; below: as in `Levels`."""
    return Levels(pixels, vpls // MOST_MEMBERS, vpls // LEAST_MEMBERS, below=below)

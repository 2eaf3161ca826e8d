"""Counts of clusters among which a target chooses (gpu.adaptive.governor): levels."""

from dataclasses import dataclass
from math import log

# Numbers of SP clusters, or of passes, are so far apart. Of VPL clusters they are whole words of visibility bits.
STEP = 1.06
WORD, VPL_STEP = 32, 2.0**0.25
# SP clusters for each VPL cluster: as in the default counts of a GPU, and how many times that or how little of it.
SPS_PER_VPL, RANGE = 4.0, 6.0
# How little of it for an error: SPs' own rays find most of what few clusters lack, and views of even walls need few.
ERROR_RANGE = 48.0
# How little of it for a time: the fewer SP clusters there are, the more VPL clusters are near them, which are shaded
# one by one (gpu.indirect.far_field), so that shading takes hardly less and fewer VPL clusters save more.
TIME_RANGE = 2.0
# For a time, SPs have rays that correct their light in up to so many passes. That takes time at once and at any view,
# for about as much less error as more SP clusters, which surfaces near by may have no room for.
MOST_PASSES = 4
# Members that a VPL cluster has on average. Those of fewer are not worth their name; those of more than a GPU's default
# counts have are shaded in their parts from afar, so that fewer of them take longer and leave no more error.
LEAST_MEMBERS, MOST_MEMBERS = 12, 48


@dataclass(frozen=True)
class Level:
    """Counts of clusters, and passes of an SP's rays that correct its light, in the mean."""

    sp_clusters: int
    vpl_clusters: int
    passes: float = 1.0

    @property
    def work(self) -> float:
        """Pairs of clusters, which most rays are in proportion to, times passes."""
        return self.sp_clusters * self.vpl_clusters * self.passes

    @property
    def vpls(self) -> int:
        """VPLs that they need at most."""
        return MOST_MEMBERS * self.vpl_clusters


MOST = Level(sp_clusters=131_072, vpl_clusters=16_384)


class Levels:
    """The levels of an image of so many pixels, with about `least` … `most` VPL clusters.

    below: the usual number of SP clusters over the fewest. passes: the most there are; a level has more than one once
    it has the usual number of SP clusters, and more SP clusters once it has the most passes.
    """

    def __init__(
        self,
        pixels: int,
        least: int = WORD,
        most: int = MOST.vpl_clusters,
        *,
        below: float = ERROR_RANGE,
        passes: int = 1,
    ) -> None:
        self._most, self._below = min(pixels, MOST.sp_clusters), below
        self._passes = [STEP**step for step in range(int(log(passes, STEP)) + 1)]
        steps = range(round(log(MOST.vpl_clusters / WORD, VPL_STEP)) + 1)
        numbers = sorted({WORD * round(VPL_STEP**step) for step in steps})
        few = [number for number in numbers if number <= most] or numbers[:1]
        self.vpl_clusters = [number for number in few if number >= least] or few[-1:]
        self._of: dict[int, tuple[Level, ...]] = {}

    def usual(self, vpl_clusters: int) -> Level:
        """The level of so many VPL clusters with the usual number of SP clusters for each, and one pass."""
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
            usual = self.usual(vpl_clusters).sp_clusters
            fewer, more = (int(log(times, STEP)) for times in (self._below, RANGE))
            wanted = (round(usual * STEP**step) for step in range(-fewer, more + 1))
            counts = sorted({min(max(count, 1), self._most) for count in wanted})
            few = [Level(count, vpl_clusters) for count in counts if count <= usual]
            same = [Level(usual, vpl_clusters, passes) for passes in self._passes[1:]]
            many = [Level(count, vpl_clusters, self._passes[-1]) for count in counts if count > usual]
            self._of[vpl_clusters] = (*few, *same, *many)
        return self._of[vpl_clusters]


def levels_of(pixels: int, vpls: int, *, below: float = ERROR_RANGE, passes: int = 1) -> Levels:
    """The levels of an image of so many pixels that is lit by so many VPLs; below, passes: as in `Levels`."""
    return Levels(pixels, vpls // MOST_MEMBERS, vpls // LEAST_MEMBERS, below=below, passes=passes)

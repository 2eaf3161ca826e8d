"""Counts of clusters among which a target chooses (gpu.adaptive.governor): levels."""

from dataclasses import dataclass
from math import log

# Numbers of VPL clusters are whole words of visibility bits.
WORD = 32


@dataclass(frozen=True)
class LevelParameters:
    """step: numbers of SP clusters, or of passes, are so many times the next; vpl_step: those of VPL clusters.

    sps_per_vpl: SP clusters for each VPL cluster, as in the default counts of a GPU. above, below: how many times that,
    or how little of it, there are at the most. For an error few will do: SPs' own rays find most of what few clusters
    lack, and views of even walls need few. For a time they would save nothing: the fewer SP clusters there are, the
    more VPL clusters are near them, which are shaded one by one (gpu.indirect.far_field).
    passes: that SPs' rays which correct their light have at the most. They take time at once and at any view, for about
    as much less error as more SP clusters, which surfaces near by may have no room for.
    least_members, most_members: of a VPL cluster on average. Those of fewer are not worth their name; those of more
    than a GPU's default counts have are shaded in their parts from afar, so that fewer take longer and leave no
    more error.
    """

    step: float = 1.06
    vpl_step: float = 2.0**0.25
    sps_per_vpl: float = 4.0
    above: float = 6.0
    below: float = 48.0
    passes: int = 1
    least_members: int = 12
    most_members: int = 48


FOR_ERROR, FOR_TIME = LevelParameters(), LevelParameters(below=2.0, passes=4)


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
        """VPLs that its clusters need at most."""
        return FOR_TIME.most_members * self.vpl_clusters


MOST = Level(sp_clusters=131_072, vpl_clusters=16_384)


class Levels:
    """The levels of an image of so many pixels, with about `least` … `most` VPL clusters.

    A level has more than one pass once it has the usual number of SP clusters, and more SP clusters once it has the
    most passes.
    """

    def __init__(
        self,
        pixels: int,
        least: int = WORD,
        most: int = MOST.vpl_clusters,
        parameters: LevelParameters = FOR_ERROR,
    ) -> None:
        self._most, self._parameters = min(pixels, MOST.sp_clusters), parameters
        steps = range(round(log(MOST.vpl_clusters / WORD, parameters.vpl_step)) + 1)
        numbers = sorted({WORD * round(parameters.vpl_step**step) for step in steps})
        few = [number for number in numbers if number <= most] or numbers[:1]
        self.vpl_clusters = [number for number in few if number >= least] or few[-1:]
        self._of: dict[int, tuple[Level, ...]] = {}

    def usual(self, vpl_clusters: int) -> Level:
        """The level of so many VPL clusters with the usual number of SP clusters for each, and one pass."""
        return Level(min(round(self._parameters.sps_per_vpl * vpl_clusters), self._most), vpl_clusters)

    def most(self, vpl_clusters: int) -> int:
        """The most SP clusters of a level with so many VPL clusters."""
        return self.of(vpl_clusters)[-1].sp_clusters

    def nearest(self, work: float) -> Level:
        """The usual level that is nearest to so much `work`."""
        return min(map(self.usual, self.vpl_clusters), key=lambda level: abs(log(level.work / work)))

    def of(self, vpl_clusters: int) -> tuple[Level, ...]:
        """All levels of so many VPL clusters, by work."""
        if vpl_clusters not in self._of:
            own, usual = self._parameters, self.usual(vpl_clusters).sp_clusters
            fewer, more, most = (int(log(times, own.step)) for times in (own.below, own.above, own.passes))
            passes = [own.step**step for step in range(most + 1)]
            wanted = (round(usual * own.step**step) for step in range(-fewer, more + 1))
            counts = sorted({min(max(count, 1), self._most) for count in wanted})
            few = [Level(count, vpl_clusters) for count in counts if count <= usual]
            same = [Level(usual, vpl_clusters, number) for number in passes[1:]]
            many = [Level(count, vpl_clusters, passes[-1]) for count in counts if count > usual]
            self._of[vpl_clusters] = (*few, *same, *many)
        return self._of[vpl_clusters]


def levels_of(pixels: int, vpls: int, parameters: LevelParameters = FOR_ERROR) -> Levels:
    """The levels of an image of so many pixels that is lit by so many VPLs."""
    return Levels(pixels, vpls // parameters.most_members, vpls // parameters.least_members, parameters)

"""What a frame of other counts of clusters would take, learnt from what frames took."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import log, sqrt

from gpu.levels import Level


@dataclass(frozen=True)
class Growth:
    """How a stage's time changes with counts: a share `pairs` of what it takes at the usual counts with their product.

    The rest is in proportion to a power `sps` of the number of SP clusters and one `vpls` of that of VPL clusters.
    """

    sps: float = 0.0
    vpls: float = 0.0
    pairs: float = 0.0


# Of frames that begin from nothing: between 1000 and 30,000 SP clusters and 750 and 4000 VPL clusters, in six scenes on
# an H100. Other stages change with no count.
FROM_NOTHING = {
    "cluster": Growth(sps=0.2),
    "visibility": Growth(sps=0.8, vpls=0.8),
    "shade": Growth(sps=0.4, vpls=0.8),
    "refine": Growth(sps=0.5),
}
# Of those in motion, which keep clusters: with 4096 to 131,072 SP clusters and 512 to 8192 VPL clusters, in four scenes
# on an H200.
IN_MOTION = {
    "cluster": Growth(sps=0.2),
    "visibility": Growth(pairs=0.2),
    "shade": Growth(vpls=0.3, pairs=0.2),
    "refine": Growth(sps=0.3),
}
# Frames that are pooled, and the share of each miss by which the next frames are taken to change.
FRAMES, TREND = 2.0, 0.2
# A frame with more than so many times what was expected, or less than that part of it, for which the system around may
# be to blame, counts only when the next one is no better, and then in full.
SURPRISE = 1.5
# SP clusters in use become more as long as they are less than this share of those wanted, and so many times those of
# the frame before.
FULL, FILLS = 0.95, 1.01
# So near the target a level stays: the first frame of another takes longer.
NEAR = log(1.05)


@dataclass(frozen=True)
class Times:
    """What a frame's `stages`, and its host, took [ms], by name, with so many SP clusters in use.

    A walk that is to have more has them only little by little, and no more than its surfaces take.
    """

    stages: Mapping[str, float]
    sp_clusters: int


class TimeModel:
    """Times of a frame's parts [ms], its stages and the host's, by name: a frame's are like those of the one before."""

    def __init__(self, usual: Level, growths: Mapping[str, Growth]) -> None:
        """usual: counts of a device for which `growths`, by stages' names, tell shares."""
        self._usual, self._growths = usual, growths
        self._seen = 0
        self._units: dict[str, float] = {}
        self._trend, self._square = 1.0, 0.0
        self._level: Level | None = None
        self._surprised = False
        # Of the wanted SP clusters the share that comes into use; those of the last frame, and whether more come.
        self._fill, self._used, self._grows = 1.0, 0, False

    @property
    def near(self) -> float:
        """How far off a target, in logarithms, is near enough: as far, and by the noise of what is learnt."""
        if self._seen < 2:
            return 1.0
        share = self._share
        return NEAR + sqrt(self._square * share / (2.0 - share))

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture, with all clusters that come into use."""
        return self._seen >= FRAMES and not self._grows

    def observe(self, level: Level, seen: Times) -> None:
        """A frame for which `level` was chosen took so long."""
        stages, used = seen.stages, replace(level, sp_clusters=max(seen.sp_clusters, 1))
        self._see_fill(used.sp_clusters, level.sp_clusters)
        ratio = sum(stages.values()) / self._predict(used) if self._seen else 1.0
        surprised = not 1.0 / SURPRISE <= ratio <= SURPRISE
        if surprised and not self._surprised:
            self._surprised = True
            return
        if surprised:
            self._units = {name: unit * ratio for name, unit in self._units.items()}
        else:
            miss = min(max(ratio - 1.0, -1.0), 1.0)
            self._trend *= 1.0 + TREND * miss
            if level == self._level:  # else a miss tells of the powers, not of noise
                self._square += self._share * (miss**2 - self._square)
        self._surprised, self._level = False, level
        self._seen += 1
        for name, value in stages.items():
            unit = value / self._scale(name, used)
            expected = self._units.get(name, unit) * self._trend
            self._units[name] = expected + self._share * (unit - expected)

    def predict(self, level: Level) -> float:
        """What the next frame takes at `level` [ms], above zero; nothing is known before the first observation."""
        return self._predict(replace(level, sp_clusters=max(round(self._fill * level.sp_clusters), 1)))

    def _predict(self, used: Level) -> float:
        """What the next frame takes with so many clusters in use [ms]."""
        parts = (max(unit, 1e-12) * self._scale(name, used) for name, unit in self._units.items())
        return self._trend * sum(parts)

    def _see_fill(self, used: int, wanted: int) -> None:
        """Learn of the last frame which share of the `wanted` SP clusters comes into use."""
        fill = min(used / wanted, 1.0)
        self._used, self._grows = used, fill < FULL and used > FILLS * self._used
        if not self._grows:
            self._fill = fill

    @property
    def _share(self) -> float:
        return 1.0 / max(min(self._seen, FRAMES), 1.0)

    def _scale(self, name: str, level: Level) -> float:
        growth = self._growths.get(name, Growth())
        sps = level.sp_clusters / self._usual.sp_clusters
        vpls = level.vpl_clusters / self._usual.vpl_clusters
        return float((1.0 - growth.pairs) * sps**growth.sps * vpls**growth.vpls + growth.pairs * sps * vpls)

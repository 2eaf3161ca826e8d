"""Which counts of clusters meet a wanted frame time or error: the future work of the 2022 paper (its section 5).

Levels are pairs of counts in steps of equal work. A model learns from the frames so far what a level will take, or how
far from the truth it will be; a governor takes the level that comes nearest to the target, and stays where it is while
that is near enough, since new clusters are seen as flicker. Nothing here renders.
"""

from bisect import bisect_left
from dataclasses import dataclass
from math import log, sqrt
from typing import Protocol

import numpy as np

# A level has this much more work than the one before.
STEP = 1.09
LEAST_WORK, MOST_WORK = 2.0**12, 2.0**30
# SP clusters for each VPL cluster, as in the default counts of a GPU.
SPS_PER_VPL = 4.0
# VPL clusters come in few numbers, since each needs a light set of its own: √2 apart, whole words of visibility bits.
WORD = 32
# Members that a VPL cluster has on average, or more.
LEAST_MEMBERS = 12
# Too near the target to move.
NEAR_ENOUGH = log(1.04)
# A model is trusted no farther than this from what it has seen, in work.
FARTHEST = 4.0


@dataclass(frozen=True)
class Level:
    """Counts of clusters, and of the VPLs that they need."""

    sp_clusters: int
    vpl_clusters: int

    @property
    def work(self) -> float:
        """Pairs of clusters: what rays, and with them most of a frame's time, are in proportion to."""
        return float(self.sp_clusters) * self.vpl_clusters

    @property
    def vpls(self) -> int:
        """The least number of VPLs that makes clusters of them worth their name."""
        return LEAST_MEMBERS * self.vpl_clusters


MOST = Level(round(sqrt(MOST_WORK * SPS_PER_VPL)), round(sqrt(MOST_WORK / SPS_PER_VPL)))


def ladder(pixels: int, vpls: int | None = None) -> tuple[Level, ...]:
    """The levels for an image of so many pixels and so many VPLs, or as many as need be; from the least work on."""
    halves = range(21)
    numbers = sorted({WORD * max(1, round(MOST.vpl_clusters * 2.0 ** (-half / 2.0) / WORD)) for half in halves})
    if vpls is not None:
        numbers = [number for number in numbers if number * LEAST_MEMBERS <= vpls] or numbers[:1]
    levels: list[Level] = []
    steps = int(log(MOST_WORK / LEAST_WORK) / log(STEP)) + 1
    for step in range(steps):
        work = min(LEAST_WORK * STEP**step, MOST_WORK)
        wanted = max(sqrt(work / SPS_PER_VPL), work / pixels)
        clusters = min(numbers, key=lambda number: abs(log(number / wanted)))
        level = Level(min(round(work / clusters), pixels, MOST.sp_clusters), clusters)
        if not levels or level.work > levels[-1].work:
            levels.append(level)
    return tuple(levels)


class Model(Protocol):
    """What a level gives, learnt from what levels gave."""

    def observe(self, work: float, value: float) -> None:
        """A frame of a level with `work` gave `value`."""

    def predict(self, work: float) -> float:
        """What a level with `work` will give; nothing is known before the first observation."""

    @property
    def doubt(self) -> float:
        """Standard deviation of predictions, relative to them."""

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""


class TimeModel:
    """Time of a frame [ms]: a part that no cluster changes, and one in proportion to work. A Kalman filter of the two.

    A time far off what was expected, for which the system around may be to blame, counts only when the next one
    confirms it.
    """

    NOISE, GAIN_DRIFT, SHAPE_DRIFT = 0.03, 0.02, 0.01
    OUTLIER = 4.0

    def __init__(self) -> None:
        self._frames = 0
        self._unit = 0.0  # work in which the second part is counted
        self._parts = np.zeros(2)
        self._covariance = np.zeros((2, 2))
        self._surprised = False

    @property
    def doubt(self) -> float:
        """Nothing to speak of: times repeat."""
        return 0.0

    @property
    def ready(self) -> bool:
        """Two times tell the two parts."""
        return self._frames >= 2

    def observe(self, work: float, value: float) -> None:
        """A frame took `value` ms."""
        self._frames += 1
        if self._unit == 0.0:
            self._unit = work
            self._parts = value * np.array([0.4, 0.6])
            self._covariance = np.diag((0.3 * value) ** 2 * np.ones(2))
        seen, parts = np.array([1.0, work / self._unit]), self._parts
        together = np.outer(parts, parts)
        covariance = self._covariance + self.GAIN_DRIFT**2 * together + self.SHAPE_DRIFT**2 * np.diag(parts**2)
        expected = float(seen @ parts)
        noise = (self.NOISE * expected) ** 2
        if abs(value - expected) > self.OUTLIER * sqrt(float(seen @ covariance @ seen) + noise):
            self._surprised = not self._surprised
            if self._surprised:
                return
            covariance = covariance + together * (value / expected - 1.0) ** 2
        self._surprised = False
        gain = covariance @ seen / (float(seen @ covariance @ seen) + noise)
        least = 0.02 * value
        self._parts = np.maximum(parts + gain * (value - expected), [least, least * self._unit / work])
        self._covariance = covariance - np.outer(gain, seen @ covariance)

    def predict(self, work: float) -> float:
        """Time of a frame [ms]."""
        return float(self._parts[0] + self._parts[1] * work / self._unit)


class ErrorModel:
    """Error of a frame: a power of work, of which the factor is learnt.

    Estimates are few pixels' and noisy, some even negative, but right in the mean: so they are pooled over `WINDOW`
    frames before any logarithm is taken.
    """

    POWER = 0.4
    WINDOW = 64.0
    FIRST_FRAMES = 8.0

    def __init__(self) -> None:
        self._frames = self._total = self._square = 0.0

    @property
    def doubt(self) -> float:
        """Standard deviation of the pooled factor, relative to it; 1 where nothing is known."""
        if self._frames < 2.0 or self._total <= 0.0:
            return 1.0
        mean = self._total / self._frames
        return sqrt(max(self._square / self._frames / mean**2 - 1.0, 0.0) / self._frames)

    @property
    def ready(self) -> bool:
        """A few frames."""
        return self._frames > self.FIRST_FRAMES * (1.0 - self.FIRST_FRAMES / self.WINDOW)

    def observe(self, work: float, value: float) -> None:
        """A frame's error was estimated as `value`."""
        factor, kept = value * work**self.POWER, 1.0 - 1.0 / self.WINDOW
        self._frames = kept * self._frames + 1.0
        self._total = kept * self._total + factor
        self._square = kept * self._square + factor * factor

    def predict(self, work: float) -> float:
        """Error of a frame, above zero."""
        return max(self._total / self._frames, 1e-12) * work**-self.POWER


class Governor:
    """Chooses one of `levels`, by what `model` learns of them, for frames to give `target`; starts at about `work`."""

    def __init__(self, levels: tuple[Level, ...], model: Model, target: float, work: float) -> None:
        self._levels, self._model, self._target = levels, model, target
        self._index = min(bisect_left([level.work for level in levels], work), len(levels) - 1)
        self.expected: float | None = None

    @property
    def level(self) -> Level:
        """The level of the next frame."""
        return self._levels[self._index]

    def learn(self, value: float) -> bool:
        """A frame of `level` gave `value`; True when that can stay: it is near enough, or as near as can be."""
        work, model = self.level.work, self._model
        model.observe(work, value)

        def off(index: int) -> float:
            return abs(log(model.predict(self._levels[index].work) / self._target))

        begin, end = (self._place(work * reach) for reach in (1.0 / FARTHEST, FARTHEST))
        best = min(range(begin, end + 1), key=off)
        settled = off(self._index) <= NEAR_ENOUGH + 0.5 * model.doubt or best == self._index
        if not settled:
            self._index = best
        self.expected = model.predict(self.level.work)
        return settled and model.ready

    def _place(self, work: float) -> int:
        return min(bisect_left(self._levels, work, key=lambda level: level.work), len(self._levels) - 1)

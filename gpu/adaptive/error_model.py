"""What error a frame of other counts of clusters would have, learnt from noisy estimates.

An error is a mean over a picture's pixels, and those without light have none: how many have light is known without
noise. The error of the others is a view's hardness times powers of the counts. The logarithm of hardness, and how fast
it changes from frame to frame, are followed by an α-β filter, whose gains fall with an estimate's noise. How much SP
clusters help is learnt where a view is tried again with others.
"""

from dataclasses import dataclass
from math import exp, isfinite, log

from gpu.adaptive.levels import FOR_ERROR, Level

# What errors can be: black is all right, and clipped squares end at 1.
LEAST_ERROR, MOST_ERROR = 1e-12, 1.0


@dataclass(frozen=True)
class ErrorModelParameters:
    """sp_power, vpl_power: errors fall with about these powers of SP clusters, near their usual number, and of VPL
    clusters, where the ratio of both stays: by 40 pairs of counts in three scenes on a CPU.

    sp_share, sp_fall: errors of SP clusters add to those of VPL clusters: their share beside these at usual counts, and
    the power by which it falls. So fewer SP clusters do more harm than more do good: a sixth of the usual number leaves
    1.3, 1.4 and 1.8 times the error (Cornell box, conference room, atrium), six times that number 0.92, 0.97, 0.71.

    miss: how far views are off what is expected of them, relatively: an estimate with so much noise counts half.
    trend_gain: share of a miss, as it counts, by which the change from frame to frame changes; max_miss: no miss counts
    for more.
    min_lit: the share of pixels with light is taken to be at least this.
    power_gain: by what share sp_power, which differs much from scene to scene, moves towards what another try at a view
    tells of it, between min_power and max_power.
    near: so far from the target, in logarithms, a level stays. first_frames: what a first picture waits for.
    """

    sp_power: float = 0.12
    vpl_power: float = 0.5
    sp_share: float = 0.2
    sp_fall: float = 0.8
    miss: float = 0.06
    trend_gain: float = 0.1
    max_miss: float = 1.0
    min_lit: float = 1e-4
    power_gain: float = 0.3
    min_power: float = 0.03
    max_power: float = 1.0
    near: float = log(1.05)
    first_frames: int = 6


ERROR_MODEL_PARAMETERS = ErrorModelParameters()


@dataclass(frozen=True)
class Estimate:
    """A frame's error, and the standard deviation of its noise. It may be below zero, but is right in the mean.

    lit: the share of the frame's pixels that have light.
    """

    error: float
    deviation: float
    lit: float = 1.0


class ErrorModel:
    """Errors of levels, by estimates of those that frames had."""

    def __init__(self) -> None:
        # Logarithm of the next view's hardness, and of the last one's; and by how much it changes in a frame.
        self._hardness = self._last_hardness = log(LEAST_ERROR)
        self._trend = 0.0
        self._sp_power = ERROR_MODEL_PARAMETERS.sp_power
        # The last level and its error, and whether the next frame is of the same view.
        self._last: tuple[Level, float] | None = None
        self._holds = False
        self._lit = ERROR_MODEL_PARAMETERS.min_lit
        # Frames, and those that told something.
        self._seen = self._learnt = 0

    @property
    def near(self) -> float:
        """How far off a target, in logarithms, is near enough for a level to stay."""
        return ERROR_MODEL_PARAMETERS.near

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""
        return self._seen >= ERROR_MODEL_PARAMETERS.first_frames

    def observe(self, level: Level, seen: Estimate) -> None:
        """A frame of `level` had this error; one that is not finite, or of a black frame, tells nothing."""
        if not isfinite(seen.error) or not isfinite(seen.deviation):
            return
        if self._holds and self._last:
            self._learn_power(*self._last, level, seen.error)
        self._last, self._holds = (level, seen.error), False
        self._lit = max(seen.lit, ERROR_MODEL_PARAMETERS.min_lit)
        self._seen += 1
        if seen.lit > 0.0:
            self._learn(level, seen.error / self._lit, seen.deviation / self._lit)

    def hold_view(self) -> None:
        """The next frame is of the last one's view again, whose hardness did not change."""
        self._hardness, self._holds = self._last_hardness, True

    def predict(self, level: Level) -> float:
        """The error of the next frame at `level`; nothing is known before the first observation."""
        return exp(self._hardness - self._gain_of(level)) * self._lit

    def _sp_basis(self, level: Level) -> float:
        """The logarithm of an error that falls by a power of 1 of SP clusters near their usual number."""
        own = ERROR_MODEL_PARAMETERS
        ratio = level.sp_clusters / (FOR_ERROR.sps_per_vpl * level.vpl_clusters)
        scale = (1.0 + own.sp_share) / (own.sp_share * own.sp_fall)
        return scale * log(1.0 + own.sp_share * ratio**-own.sp_fall)

    def _gain_of(self, level: Level) -> float:
        """By how much, in logarithms, counts of `level` lower errors."""
        return ERROR_MODEL_PARAMETERS.vpl_power * log(level.vpl_clusters) - self._sp_power * self._sp_basis(level)

    def _learn_power(self, before: Level, error_before: float, level: Level, error: float) -> None:
        """Two levels of as many VPL clusters had these errors in one view: how much SP clusters help."""
        own, step = ERROR_MODEL_PARAMETERS, self._sp_basis(before) - self._sp_basis(level)
        if before.vpl_clusters != level.vpl_clusters or not step or not min(error_before, error) > 0.0:
            return
        gain = self._gain_of(before)
        power = min(max(log(error_before / error) / step, own.min_power), own.max_power)
        self._sp_power += own.power_gain * (power - self._sp_power)
        self._hardness += self._gain_of(before) - gain

    def _learn(self, level: Level, error: float, deviation: float) -> None:
        """The pixels that have light had this error, with this deviation."""
        own = ERROR_MODEL_PARAMETERS
        if not self._learnt:
            # The logarithm of the noise alone, where an estimate is below it, is as good a guess as any.
            self._hardness = log(max(error, deviation, LEAST_ERROR)) + self._gain_of(level)
        expected = exp(self._hardness - self._gain_of(level))
        miss = min(max(error / expected - 1.0, -own.max_miss), own.max_miss)
        noise = deviation / max(expected, error / (1.0 + own.max_miss))
        self._learnt += 1
        share = max(1.0 / (1.0 + (noise / own.miss) ** 2), 1.0 / self._learnt)
        least, most = (log(error) + self._gain_of(level) for error in (LEAST_ERROR, MOST_ERROR))
        self._last_hardness = min(max(self._hardness + share * miss, least), most)
        # An error at its bound no longer changes.
        at_bound = self._last_hardness in (least, most)
        self._trend = 0.0 if at_bound else self._trend + own.trend_gain * share * miss
        self._hardness = self._last_hardness + self._trend

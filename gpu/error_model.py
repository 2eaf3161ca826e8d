"""What error a frame of other counts of clusters would have, learnt from noisy estimates: a Kalman filter (1960).

Its state is what the logarithm of an error is made of: how hard the view is, how fast that changes from frame to frame,
and how much counts help in this scene. None of these stays as it is, so older frames tell ever less of them.
"""

from dataclasses import dataclass
from math import exp, isfinite, log

import numpy as np

from gpu.levels import Level
from gpu.scene.types import Floats

# Errors fall with about this power of the counts, give or take this much from scene to scene; SP clusters have this
# part in it, VPL clusters the rest. By fixed counts in three scenes on a CPU.
POWER, POWER_DEVIATION = 0.53, 0.15
SP_PART = 0.38
# What changes from one frame to the next: how hard a view is, how fast that changes, how much counts help; and the
# share of the change before that lasts. A first frame tells nothing of how fast its view changes, up to this much.
CHANGES, LASTING, FIRST_CHANGE = (0.015, 0.008, 0.003), 0.98, 0.03
# A frame's miss counts no more than this, relative to what was expected.
MOST_MISS = 1.5
# Frames whose noise tells of that of the next: a frame that happens to have more errors has more noise, too.
NOISE_FRAMES = 8
# From one frame to the next: the state goes on.
NEXT = np.array([[1.0, 1.0, 0.0], [0.0, LASTING, 0.0], [0.0, 0.0, 1.0]])
# So near the target a level stays: each other has arrays and graphs of its own.
NEAR = log(1.04)
# Frames that a first picture waits for.
FIRST_FRAMES = 6
# What errors can be: black is all right, and clipped squares end at 1. And powers: more counts do no harm.
LEAST_ERROR, MOST_ERROR = 1e-12, 1.0
LEAST_POWER, MOST_POWER = 0.1, 1.5


@dataclass(frozen=True)
class Estimate:
    """A frame's error, and the standard deviation of its noise. It may be below zero, but is right in the mean."""

    error: float
    deviation: float


class ErrorModel:
    """Errors of levels, by estimates of those that frames had."""

    def __init__(self) -> None:
        self._state = np.array([0.0, 0.0, POWER])
        self._variance = np.diag([1.0, FIRST_CHANGE**2, POWER_DEVIATION**2])
        self._noise = 0.0
        self._first: Level | None = None
        self._seen = 0

    @property
    def near(self) -> float:
        """How far off a target, in logarithms, is near enough for a level to stay."""
        return NEAR

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""
        return self._seen >= FIRST_FRAMES

    def observe(self, level: Level, seen: Estimate) -> None:
        """A frame of `level` had this error; one that is not finite tells nothing."""
        if not isfinite(seen.error) or not isfinite(seen.deviation):
            return
        if self._first is None:
            # The logarithm of the noise alone, where an estimate is below it, is as good a guess as any.
            self._first = level
            self._state[0] = log(max(seen.error, seen.deviation, LEAST_ERROR))
        self._seen += 1
        expected = self.predict(level)
        miss = min(max(seen.error / expected - 1.0, -MOST_MISS), MOST_MISS)
        noise = (seen.deviation / max(expected, seen.error / (1.0 + MOST_MISS))) ** 2
        self._noise += (noise - self._noise) / min(self._seen, NOISE_FRAMES)
        tells = self._tells(level)
        gain = self._variance @ tells / (tells @ self._variance @ tells + self._noise)
        self._state += gain * miss
        self._variance -= np.outer(gain, tells @ self._variance)
        self._state = NEXT @ self._state
        self._variance = NEXT @ self._variance @ NEXT.T + np.diag(np.square(CHANGES))
        self._bound()

    def predict(self, level: Level) -> float:
        """The error of the next frame at `level`; nothing is known before the first observation."""
        return exp(float(self._tells(level) @ self._state))

    def _tells(self, level: Level) -> Floats:
        """What the logarithm of an error of `level` is of the state."""
        first = self._first or level
        vpls, sps = level.vpl_clusters / first.vpl_clusters, level.sp_clusters / first.sp_clusters
        return np.array([1.0, 0.0, -(1.0 - SP_PART) * log(vpls) - SP_PART * log(sps)])

    def _bound(self) -> None:
        """Keep the state to what errors and powers can be; an error at its bound no longer changes."""
        error, _, power = self._state
        if not log(LEAST_ERROR) <= error <= log(MOST_ERROR):
            self._state[:2] = min(max(error, log(LEAST_ERROR)), log(MOST_ERROR)), 0.0
        self._state[2] = min(max(power, LEAST_POWER), MOST_POWER)

"""What error a frame of other counts of clusters would have, learnt from noisy estimates: a Kalman filter (1960).

An error is a mean over a picture's pixels, and those without light have none: what changes as they come and go is known
without noise, and is no matter of the filter. Its state is what the logarithm of the others' error is made of: how hard
the view is, how fast that changes from frame to frame, how much counts of SP and of VPL clusters help in this scene,
and, for each number of VPL clusters, how lucky its light set is. All but luck changes, so older frames tell ever less.
"""

from dataclasses import dataclass
from math import exp, isfinite, log

import numpy as np
from numpy.typing import NDArray

from gpu.adaptive.levels import FOR_ERROR, Level

# Errors fall with about these powers of SP clusters, near their usual number, and of VPL clusters, where the ratio of
# both stays; give or take this much from scene to scene. By 40 pairs of counts in three scenes on a CPU.
POWERS, POWER_DEVIATIONS = (0.12, 0.5), (0.06, 0.13)
# Errors of SP clusters add to those of VPL clusters: their share beside these at usual counts, and the power by which
# it falls. So fewer SP clusters do more harm than more do good. (A sixth of the usual number leaves 1.3, 1.4 and 1.8
# times the error in a Cornell box, a conference room and an atrium, six times that number 0.92, 0.97 and 0.71 times.)
SP_SHARE, SP_FALL = 0.2, 0.8
# Light sets of like numbers leave errors that differ by about this much (4 and 11 % in two views of a Cornell box), and
# by this at the most. Frames of the same counts differ by this much, since each has SP clusters of its own: that tells
# nothing of the next, no more than an estimate's noise does.
LUCK, MOST_LUCK, OWN_LUCK = 0.12, 0.4, 0.04
# What changes from one frame to the next: how hard a view is, how fast that changes, how much counts help; and the
# share of the change before that lasts. A first frame tells nothing of how fast its view changes, up to this much.
CHANGES, LASTING, FIRST_CHANGE = (0.015, 0.008, 0.003, 0.003), 0.98, 0.03
CHANGING = len(CHANGES)
# Where misses are larger than is expected of them, views change more than that: the variance of their hardness grows
# to so many times at the most, by such a power of e for each time the square that is expected of a miss, of which one
# miss is no more than so many (covariance matching, R. Mehra 1972).
MOST_UNREST, UNREST_GAIN, MOST_SURPRISE = 25.0, 0.2, 4.0
# The share of a picture's pixels that have light is taken to be no less than this, and to change no faster by a frame.
LEAST_LIT, FASTEST = 1e-4, 1.25
# A frame's miss counts no more than this, relative to what was expected.
MOST_MISS = 1.5
# Frames whose noise tells of that of the next: a frame that happens to have more errors has more noise, too.
NOISE_FRAMES = 8
# So near the target a level stays: each other has luck of its own.
NEAR = log(1.05)
# Frames that a first picture waits for.
FIRST_FRAMES = 6
# What errors can be: black is all right, and clipped squares end at 1. And powers: more counts do no harm.
LEAST_ERROR, MOST_ERROR = 1e-12, 1.0
LEAST_POWER, MOST_POWER = 0.03, 1.0


@dataclass(frozen=True)
class Estimate:
    """A frame's error, and the standard deviation of its noise. It may be below zero, but is right in the mean.

    lit: the share of the frame's pixels that have light.
    """

    error: float
    deviation: float
    lit: float = 1.0


def harm(level: Level) -> float:
    """The logarithm of an error that falls as that of SP clusters does, by a power of 1 near their usual number."""
    ratio = level.sp_clusters / (FOR_ERROR.sps_per_vpl * level.vpl_clusters)
    return log(1.0 + SP_SHARE * ratio**-SP_FALL) * (1.0 + SP_SHARE) / (SP_SHARE * SP_FALL)


class ErrorModel:
    """Errors of levels, by estimates of those that frames had."""

    def __init__(self) -> None:
        self._state = np.array([log(LEAST_ERROR), 0.0, *POWERS])
        self._variance = np.diag(np.square([1.0, FIRST_CHANGE, *POWER_DEVIATIONS]))
        # The variance of an estimate; and that of a change of hardness, over what it usually is.
        self._noise, self._unrest = 0.0, 1.0
        # Where the state has the luck of so many VPL clusters.
        self._luck: dict[int, int] = {}
        # The state and its variance at the last view; and whether the next frame is of that view again.
        self._here = self._state, self._variance
        self._stays = False
        # Of the last view, of the one before and, expected, of the next.
        self._lit = self._lit_before = self._next_lit = LEAST_LIT
        self._first: Level | None = None
        # Frames, and those that told something.
        self._seen = self._learnt = 0

    @property
    def near(self) -> float:
        """How far off a target, in logarithms, is near enough for a level to stay."""
        return NEAR

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""
        return self._seen >= FIRST_FRAMES

    def observe(self, level: Level, seen: Estimate) -> None:
        """A frame of `level` had this error; one that is not finite, or of a black frame, tells nothing."""
        if not isfinite(seen.error) or not isfinite(seen.deviation):
            return
        self._follow_light(max(seen.lit, LEAST_LIT))
        self._seen += 1
        if seen.lit > 0.0:
            self._learn(level, seen.error / self._lit, seen.deviation / self._lit)
            self._go_on()

    def stay(self) -> None:
        """The next frame is of the last one's view again, whose light is known and whose hardness did not change."""
        self._state, self._variance = self._here
        self._next_lit, self._stays = self._lit, True

    def leave(self) -> None:
        """It is not, after all."""
        self._go_on()
        self._follow_light(self._lit)

    def predict(self, level: Level) -> float:
        """The error of the next frame at `level`; nothing is known before the first observation."""
        return self._error(level) * self._next_lit

    def _error(self, level: Level) -> float:
        """The error of the pixels that have light, at `level`."""
        return exp(float(self._tells(level) @ self._state))

    def _tells(self, level: Level) -> NDArray[np.float64]:
        """What the logarithm of an error of `level` is of the state."""
        first = self._first or level
        tells = np.zeros(len(self._state))
        tells[:CHANGING] = 1.0, 0.0, harm(level) - harm(first), -log(level.vpl_clusters / first.vpl_clusters)
        if level.vpl_clusters in self._luck:
            tells[self._luck[level.vpl_clusters]] = 1.0
        return tells

    def _follow_light(self, lit: float) -> None:
        """That share of the frame's pixels has light: what changed since the view before changes once more."""
        if not self._stays:
            self._lit_before = self._lit if self._seen else lit
        self._lit, self._stays = lit, False
        faster = min(max(lit / self._lit_before, 1.0 / FASTEST), FASTEST)
        self._next_lit = min(max(lit * faster, LEAST_LIT), 1.0)

    def _learn(self, level: Level, error: float, deviation: float) -> None:
        """The pixels that have light had this error, with this deviation: the filter's update."""
        if self._first is None:
            # The logarithm of the noise alone, where an estimate is below it, is as good a guess as any.
            self._first = level
            self._state[0] = log(max(error, deviation, LEAST_ERROR))
        self._take_in(level.vpl_clusters)
        expected = self._error(level)
        miss = min(max(error / expected - 1.0, -MOST_MISS), MOST_MISS)
        noise = (deviation / max(expected, error / (1.0 + MOST_MISS))) ** 2 + OWN_LUCK**2
        self._learnt += 1
        self._noise += (noise - self._noise) / min(self._learnt, NOISE_FRAMES)
        tells = self._tells(level)
        spread = tells @ self._variance @ tells + self._noise
        surprise = min(miss**2 / spread, MOST_SURPRISE)
        self._unrest = min(max(self._unrest * exp(UNREST_GAIN * (surprise - 1.0)), 1.0), MOST_UNREST)
        gain = self._variance @ tells / spread
        self._state = self._state + gain * miss
        self._variance = self._variance - np.outer(gain, tells @ self._variance)

    def _take_in(self, vpl_clusters: int) -> None:
        """Have room in the state for the luck of this number of VPL clusters."""
        if vpl_clusters in self._luck:
            return
        self._luck[vpl_clusters] = len(self._state)
        self._state = np.append(self._state, 0.0)
        self._variance = np.pad(self._variance, (0, 1))
        self._variance[-1, -1] = LUCK**2

    def _go_on(self) -> None:
        """To the next view, by what errors and powers can be; an error at its bound no longer changes."""
        self._here = self._state, self._variance
        following = np.eye(len(self._state))
        following[:2, :2] = [[1.0, 1.0], [0.0, LASTING]]
        self._state = following @ self._state
        self._variance = following @ self._variance @ following.T
        self._variance[range(CHANGING), range(CHANGING)] += np.square(CHANGES)
        self._variance[0, 0] += (self._unrest - 1.0) * CHANGES[0] ** 2
        error = self._state[0]
        if not log(LEAST_ERROR) <= error <= log(MOST_ERROR):
            self._state[:2] = min(max(error, log(LEAST_ERROR)), log(MOST_ERROR)), 0.0
        self._state[2:CHANGING] = np.clip(self._state[2:CHANGING], LEAST_POWER, MOST_POWER)
        self._state[CHANGING:] = np.clip(self._state[CHANGING:], -MOST_LUCK, MOST_LUCK)

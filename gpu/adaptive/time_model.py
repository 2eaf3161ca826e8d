"""What a frame of other counts of clusters would take, learnt from what frames took."""

from collections.abc import Mapping
from math import log, sqrt

from gpu.adaptive.levels import Level

# Powers of SP clusters, of VPL clusters and of passes that a stage's time is in proportion to, between 1000 and 30,000
# SP clusters and 750 and 4000 VPL clusters, in six scenes on an H100. Shading's of SP clusters is by walks on an H200,
# with 6000 to 65,000 of them, correcting's by 1 to 4 passes in four scenes there. Other stages change with none.
POWERS = {
    "cluster": (0.2, 0.0, 0.0),
    "visibility": (0.8, 0.8, 0.0),
    "shade": (0.4, 0.8, 0.0),
    "correct": (0.0, 0.0, 0.65),
    "refine": (0.5, 0.0, 0.0),
}
# Frames that are pooled, and the share of each miss by which the next frames are taken to change.
FRAMES, TREND = 2.0, 0.2
# A frame with more than so many times what was expected, or less than that part of it, for which the system around may
# be to blame, counts only when the next one is no better, and then in full.
SURPRISE = 1.5
# So near the target a level stays: the first frame of another takes longer.
NEAR = log(1.05)


class TimeModel:
    """Times of a frame's parts [ms], its stages and the host's, by name: a frame's are like those of the one before."""

    def __init__(self) -> None:
        self._seen = 0
        self._units: dict[str, float] = {}
        self._trend, self._square = 1.0, 0.0
        self._level: Level | None = None
        self._surprised = False

    @property
    def near(self) -> float:
        """How far off a target, in logarithms, is near enough: as far, and by the noise of what is learnt."""
        if self._seen < 2:
            return 1.0
        share = self._share
        return NEAR + sqrt(self._square * share / (2.0 - share))

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""
        return self._seen >= FRAMES

    def observe(self, level: Level, stages: Mapping[str, float]) -> None:
        """A frame of `level` took so long for these `stages` [ms]."""
        ratio = sum(stages.values()) / self.predict(level) if self._seen else 1.0
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
            unit = value / self._scale(name, level)
            expected = self._units.get(name, unit) * self._trend
            self._units[name] = expected + self._share * (unit - expected)

    def predict(self, level: Level) -> float:
        """What the next frame takes at `level` [ms], above zero; nothing is known before the first observation."""
        parts = (max(unit, 1e-12) * self._scale(name, level) for name, unit in self._units.items())
        return self._trend * sum(parts)

    @property
    def _share(self) -> float:
        return 1.0 / max(min(self._seen, FRAMES), 1.0)

    def _scale(self, name: str, level: Level) -> float:
        if name not in POWERS:
            return 1.0
        sps, vpls, passes = POWERS[name]
        return float(level.sp_clusters**sps * level.vpl_clusters**vpls * level.passes**passes)

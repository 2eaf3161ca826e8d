"""What a frame of other counts of clusters would take, learnt from what frames took."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import sqrt

from gpu.adaptive.levels import Level

# Of SP clusters, of VPL clusters and of passes: what a stage's time is in proportion to. Others change with none.
Powers = Mapping[str, tuple[float, float, float]]


@dataclass(frozen=True)
class TimeModelParameters:
    """powers: of stages, between 1000 and 30,000 SP clusters and 750 and 4000 VPL clusters, in six scenes on an H100;
    shading's of SP clusters by walks on an H200, with 6000 to 65,000; correcting's by 1 to 4 passes in four scenes
    there.

    frames: that are pooled; trend: the share of each miss by which the next frames are taken to change.
    surprise: a frame with more than so many times what was expected, or less than that part of it, for which the system
    around may be to blame, counts only when the next one is no better, and then in full.
    near: so far from the target, in logarithms, a level stays, since the first frame of another takes longer.
    """

    powers: Powers = field(
        default_factory=lambda: {
            "cluster": (0.2, 0.0, 0.0),
            "visibility": (0.8, 0.8, 0.0),
            "shade": (0.4, 0.8, 0.0),
            "correct": (0.0, 0.0, 0.65),
            "refine": (0.5, 0.0, 0.0),
        }
    )
    frames: float = 2.0
    trend: float = 0.2
    surprise: float = 1.5
    near: float = 0.05


TIME_MODEL_PARAMETERS = TimeModelParameters()


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
        return TIME_MODEL_PARAMETERS.near + sqrt(self._square * share / (2.0 - share))

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""
        return self._seen >= TIME_MODEL_PARAMETERS.frames

    def observe(self, level: Level, stages: Mapping[str, float]) -> None:
        """A frame of `level` took so long for these `stages` [ms]."""
        ratio = sum(stages.values()) / self.predict(level) if self._seen else 1.0
        most = TIME_MODEL_PARAMETERS.surprise
        surprised = not 1.0 / most <= ratio <= most
        if surprised and not self._surprised:
            self._surprised = True
            return
        if surprised:
            self._units = {name: unit * ratio for name, unit in self._units.items()}
        else:
            miss = min(max(ratio - 1.0, -1.0), 1.0)
            self._trend *= 1.0 + TIME_MODEL_PARAMETERS.trend * miss
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
        return 1.0 / max(min(self._seen, TIME_MODEL_PARAMETERS.frames), 1.0)

    def _scale(self, name: str, level: Level) -> float:
        sps, vpls, passes = TIME_MODEL_PARAMETERS.powers.get(name, (0.0, 0.0, 0.0))
        return float(level.sp_clusters**sps * level.vpl_clusters**vpls * level.passes**passes)

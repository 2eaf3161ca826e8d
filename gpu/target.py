"""Which counts of clusters meet a wanted frame time or error: the future work of the 2022 paper (its section 5).

A model learns what the parts of frames take, or how far these are from the truth, and so what other counts would give;
a governor takes the level that comes nearest to the target, and stays where it is while that is near enough. For a time
SP clusters do most of the governing. VPL clusters come in few numbers, since each needs a light set of its own: another
is taken only where SP clusters do not suffice. Nothing here renders.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, log, sqrt

# Numbers of SP clusters are so far apart. Of VPL clusters they are whole words of visibility bits.
SP_STEP = 1.06
WORD, VPL_STEP = 32, 2.0**0.25
# SP clusters for each VPL cluster: as in the default counts of a GPU, and how many times that or how little of it.
SPS_PER_VPL, RANGE = 4.0, 6.0
# Members that a VPL cluster has on average. Those of fewer are not worth their name; those of more than a GPU's default
# counts have are shaded in their parts from afar, so that fewer of them take longer.
LEAST_MEMBERS, MOST_MEMBERS = 12, 48
# Too near the target to move: a move begins from nothing, which takes a frame longer. Where SP clusters alone come as
# near as ALMOST, no other VPL clusters are taken.
NEAR_ENOUGH, ALMOST = log(1.06), log(1.08)
# A model is trusted no farther than this from what it has seen, in work.
FARTHEST = 4.0


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


MOST = Level(sp_clusters=65_536, vpl_clusters=16_384)


class Levels:
    """The levels of an image of so many pixels, with about `least` … `most` VPL clusters."""

    def __init__(self, pixels: int, least: int = WORD, most: int = MOST.vpl_clusters) -> None:
        self._most = min(pixels, MOST.sp_clusters)
        steps = range(round(log(MOST.vpl_clusters / WORD, VPL_STEP)) + 1)
        numbers = sorted({WORD * round(VPL_STEP**step) for step in steps})
        few = [number for number in numbers if number <= most] or numbers[:1]
        self.vpl_clusters = [number for number in few if number >= least] or few[-1:]

    def usual(self, vpl_clusters: int) -> Level:
        """The level of so many VPL clusters with the usual number of SP clusters for each."""
        return Level(min(round(SPS_PER_VPL * vpl_clusters), self._most), vpl_clusters)

    def nearest(self, work: float) -> Level:
        """The usual level that is nearest to so much `work`."""
        return min(map(self.usual, self.vpl_clusters), key=lambda level: abs(log(level.work / work)))

    def of(self, vpl_clusters: int) -> list[Level]:
        """All levels of so many VPL clusters: the usual one, then the others by work."""
        usual, steps = self.usual(vpl_clusters), int(log(RANGE, SP_STEP))
        wanted = (round(usual.sp_clusters * SP_STEP**step) for step in range(-steps, steps + 1))
        counts = {min(max(count, 1), self._most) for count in wanted}
        return [usual, *(Level(count, vpl_clusters) for count in sorted(counts - {usual.sp_clusters}))]


class Model:
    """What a level gives, learnt from what levels gave: a sum of parts, each in proportion to powers of its counts.

    powers: of SP and of VPL clusters, by the name of the part; a part without changes with no count. frames: how many
    are pooled, about; trend: the share of each miss by which the next frames are taken to change. A frame with more
    than `surprise` times what was expected, or less than that part of it, for which the system around may be to blame,
    counts only when the next one is no better, and then in full.
    """

    def __init__(
        self, powers: Mapping[str, tuple[float, float]], *, frames: float, trend: float = 0.0, surprise: float = inf
    ) -> None:
        self._powers, self._frames, self._rate, self._surprise = powers, frames, trend, surprise
        self._seen = 0
        self._units: dict[str, float] = {}
        self._trend, self._square = 1.0, 0.0
        self._level: Level | None = None
        self._surprised = False

    @property
    def doubt(self) -> float:
        """Standard deviation of what is learnt, relative to it; 1 where nothing is known."""
        if self._seen < 2:
            return 1.0
        return sqrt(self._square * self._share / (2.0 - self._share))

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""
        return self._seen >= self._frames

    def observe(self, level: Level, parts: Mapping[str, float]) -> None:
        """A frame of `level` had these `parts`; they may be noisy and even negative, but must be right in the mean."""
        ratio = sum(parts.values()) / self.predict(level) if self._seen else 1.0
        surprised = self._surprise < inf and not 1.0 / self._surprise <= ratio <= self._surprise
        if surprised and not self._surprised:
            self._surprised = True
            return
        if surprised:
            self._units = {name: unit * ratio for name, unit in self._units.items()}
        else:
            miss = min(max(ratio - 1.0, -1.0), 1.0)
            self._trend *= 1.0 + self._rate * miss
            if level == self._level:  # else a miss tells of the powers, not of noise
                self._square += self._share * (miss**2 - self._square)
        self._surprised, self._level = False, level
        self._seen += 1
        for name, value in parts.items():
            unit = value / self._scale(name, level)
            expected = self._units.get(name, unit) * self._trend
            self._units[name] = expected + self._share * (unit - expected)

    def predict(self, level: Level) -> float:
        """What the next frame gives at `level`, above zero; nothing is known before the first observation."""
        parts = (max(unit, 1e-12) * self._scale(name, level) for name, unit in self._units.items())
        return self._trend * sum(parts)

    @property
    def _share(self) -> float:
        return 1.0 / max(min(self._seen, self._frames), 1.0)

    def _scale(self, name: str, level: Level) -> float:
        sps, vpls = self._powers.get(name, (0.0, 0.0))
        return float(level.sp_clusters**sps * level.vpl_clusters**vpls)


def time_model() -> Model:
    """Times of a frame's stages [ms] by their names: a frame's are like those of the one before.

    Powers are those between 1000 and 30,000 SP clusters, and 750 and 4000 VPL clusters, in six scenes on an H100.
    """
    powers = {"cluster": (0.2, 0.0), "visibility": (0.8, 0.8), "shade": (0.05, 0.8), "refine": (0.5, 0.0)}
    return Model(powers, frames=2.0, trend=0.2, surprise=1.5)


def error_model() -> Model:
    """The error of a frame, by that name: of some frames, since each one's estimate is noisy.

    SP clusters hardly matter from as many as VPL clusters on; the power is that of a fixed set of VPLs on a CPU.
    """
    return Model({"error": (0.0, -0.4)}, frames=6.0, trend=0.05)


class Governor:
    """Chooses one of `levels`, by what `model` learns of them, for frames to give `target`.

    level: that of the next frame, the first one to begin with; expected: what it will give, None before that frame.
    """

    def __init__(self, levels: Levels, model: Model, target: float, level: Level) -> None:
        self._levels, self._model, self._target = levels, model, target
        self.level = level
        self.expected: float | None = None

    def learn(self, parts: Mapping[str, float]) -> bool:
        """A frame of `level` gave `parts`; True when that can stay: it is near enough, or as near as can be."""
        model, before = self._model, self.level
        model.observe(before, parts)
        if self._off(before) > NEAR_ENOUGH + model.doubt:
            self.level = self._best()
        self.expected = model.predict(self.level)
        return self.level == before and model.ready

    def _off(self, level: Level) -> float:
        return abs(log(self._model.predict(level) / self._target))

    def _best(self) -> Level:
        """The level to go to; of equally good ones, this."""
        levels, level = self._levels, self.level

        def nearest(others: list[Level]) -> Level:
            within = (other for other in others if 1.0 / FARTHEST <= other.work / level.work <= FARTHEST)
            return min([level, *within], key=self._off)

        same = nearest(levels.of(level.vpl_clusters))
        if self._off(same) <= ALMOST:
            return same
        usual = nearest([levels.usual(number) for number in levels.vpl_clusters])
        return min(same, nearest(levels.of(usual.vpl_clusters)), key=self._off)

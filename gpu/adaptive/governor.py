"""Which counts of clusters meet a wanted frame time or error: the future work of the 2022 paper (its section 5).

A model learns what frames took, or how far they were from the truth, and so what other counts would give; a governor
takes the level that comes nearest to the target, and stays where it is while that is near enough. SP clusters, and
passes of SPs' rays, do most of the governing. VPL clusters come in few numbers, since each needs a light set of its
own: before anything is shown, that is taken whose usual level comes nearest, then another only where SP clusters and
passes do not suffice. Nothing here renders.

A governor picks counts of clusters at a fixed size of frames, for a wanted time or error; server.walk.resolution_scaler
picks the size, for usual counts; never both for one viewer, since frames with a target have their full size.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from typing import Generic, Protocol, TypeVar

from gpu.adaptive.error_model import ErrorModel, Estimate
from gpu.adaptive.levels import Level, Levels


@dataclass(frozen=True)
class GovernorParameters:
    """When counts change, and how far.

    almost: where levels of the same VPL clusters come so near the target, in logarithms, no others are taken.
    patience: so many frames in a row that told something must be beyond that for a light set to be made in a frame that
    is shown. fall, rise: a model is trusted no farther than this from what it has seen, in times less or more work.
    """

    almost: float = log(1.08)
    patience: int = 8
    fall: float = 4.0
    rise: float = 4.0


# A walk's clusters come little by little where there may be more: larger steps would show too late what they ask for.
FOR_WALK = GovernorParameters(rise=2.0)


@dataclass(frozen=True)
class ErrorGovernorParameters(GovernorParameters):
    """In units of the wanted error: what first tries aim at, and others; and what is too much to show.

    Another try of the same frame can have other lights, which so need no patience.
    """

    patience: int = 1
    aim: float = 1.03
    retry_aim: float = 1.06
    too_large: float = 1.08


Seen = TypeVar("Seen", contravariant=True)


class Model(Protocol[Seen]):
    """What levels give, learnt of what was seen of frames."""

    @property
    def near(self) -> float:
        """How far off a target, in logarithms, is near enough for a level to stay."""

    @property
    def ready(self) -> bool:
        """Whether enough was seen for a first picture."""

    def observe(self, level: Level, seen: Seen) -> None:
        """A frame of `level` gave what was `seen` of it."""

    def predict(self, level: Level) -> float:
        """What the next frame gives at `level`, above zero; nothing is known before the first observation."""


class Governor(Generic[Seen]):
    """Chooses one of `levels`, by what `model` learns of them, for frames to give `target`.

    level: that of the next frame, the first one to begin with; expected: what it will give, None before that frame.
    """

    def __init__(
        self,
        levels: Levels,
        model: Model[Seen],
        target: float,
        level: Level,
        parameters: GovernorParameters | None = None,
    ) -> None:
        self._levels, self._model, self._target = levels, model, target
        self._own = parameters or GovernorParameters()
        # Frames in a row that levels of the same VPL clusters do not bring near enough.
        self._beyond = 0
        self.level = level
        self.expected: float | None = None

    def learn(self, seen: Seen, *, anew: bool = False) -> bool:
        """A frame of `level` gave what was `seen`; True when that can stay: it is near enough, or as near as can be.

        anew: whether VPL clusters may be chosen anew, since nothing is shown yet.
        """
        model, before = self._model, self.level
        model.observe(before, seen)
        if self._off(before) > model.near:
            self.level = self._best(anew=anew)
        else:
            self._beyond = 0
        self.expected = model.predict(self.level)
        return self.level == before and model.ready

    def _off(self, level: Level) -> float:
        return abs(log(self._model.predict(level) / self._target))

    def _best(self, *, anew: bool = False) -> Level:
        """The level to go to; of equally good ones, this."""
        own, levels, level = self._own, self._levels, self.level

        def near(number: int) -> Sequence[Level]:
            every = levels.of(number)
            begin = bisect_left(every, level.work / own.fall, key=lambda other: other.work)
            return every[begin : bisect_right(every, level.work * own.rise, key=lambda other: other.work)]

        same = min([level, *self._about(near(level.vpl_clusters))], key=self._off)
        self._beyond = self._beyond + 1 if self._off(same) > own.almost else 0
        if not anew and self._beyond < own.patience:
            return same
        self._beyond = 0
        numbers = sorted(levels.vpl_clusters, key=lambda number: self._off(levels.usual(number)))
        others = self._about(next(filter(None, map(near, numbers))))
        return min(others if anew else [same, *others], key=self._off)

    def _about(self, levels: Sequence[Level]) -> Sequence[Level]:
        """Of `levels` by work those two between which the target is: what they give goes one way."""
        if not levels:
            return levels
        side = 1.0 if self._model.predict(levels[-1]) >= self._model.predict(levels[0]) else -1.0
        place = bisect_left(levels, side * self._target, key=lambda level: side * self._model.predict(level))
        return levels[max(place - 1, 0) : place + 1]


class ErrorGovernor(Governor[Estimate]):
    """One for a wanted error, `target`, of which a frame can be tried again, if its error is too large.

    One with too small an error is shown as it is, so first tries aim a little above what is wanted.
    """

    def __init__(
        self, levels: Levels, target: float, level: Level, parameters: ErrorGovernorParameters | None = None
    ) -> None:
        self._errors, self._wanted = ErrorModel(), target
        self._parameters = parameters or ErrorGovernorParameters()
        self._error = target  # the last one
        super().__init__(levels, self._errors, self._parameters.aim * target, level, self._parameters)

    def learn(self, seen: Estimate, *, anew: bool = False) -> bool:
        """As any governor does."""
        self._error = seen.error
        self._target = self._parameters.aim * self._wanted
        return super().learn(seen, anew=anew)

    def try_again(self, level: Level) -> bool:
        """Choose the level of another try at the frame of `level` that was learnt of last, if its error is too large.

        False if it is not, or if no level promises less.
        """
        if not self._error > self._parameters.too_large * self._wanted:
            return False
        # What this view has over what is expected of its level, others have, too.
        share = self._error / self._errors.predict(level)
        self._target = self._parameters.retry_aim * self._wanted / share
        best = self._best()
        expected = share * self._errors.predict(best)
        if expected >= self._error:
            return False
        self._errors.hold_view()
        self.level, self.expected = best, expected
        return True

"""Places where long work may give the device to others: between the slices of a launch, and between stages.

A process that renders for many has `DEVICE_SHARING` ask its `Turns`. Alone, nothing is asked, and nothing waits.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Protocol


class Turns(Protocol):
    """Who else wants the device."""

    def due(self) -> bool:
        """Whether somebody is to have it now: asked often, so it must take no time."""

    def give(self) -> None:
        """Let others have it. Returns when the work is to go on; raises what is to end it."""


class DeviceSharing:
    """Asks for turns."""

    def __init__(self) -> None:
        self._turns: Turns | None = None
        self._kept = 0
        self._away_seconds = 0.0  # that the work that runs now has spent in turns of others

    def begin(self, turns: Turns | None) -> None:
        """From now on ask `turns`; None: nobody."""
        self._turns = turns

    @property
    def active(self) -> bool:
        """Whether work that takes long is to be done in slices."""
        return self._turns is not None and self._kept == 0

    @property
    def due(self) -> bool:
        """Whether `pause` would give the device away."""
        return self._turns is not None and self._kept == 0 and self._turns.due()

    def own_time(self) -> float:
        """A clock that stands still in turns of others [s]."""
        return perf_counter() - self._away_seconds

    def pause(self) -> None:
        """Give the device away if that is due. What was launched before is ready."""
        if self._turns is None or not self.due:
            return
        # Others count their own time away meanwhile.
        away, begun = self._away_seconds, perf_counter()
        try:
            self._turns.give()
        finally:
            self._away_seconds = away + perf_counter() - begun

    @contextmanager
    def keep(self) -> Iterator[None]:
        """Give nothing away in here."""
        self._kept += 1
        try:
            yield
        finally:
            self._kept -= 1


DEVICE_SHARING = DeviceSharing()

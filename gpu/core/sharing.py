"""Places where long work may give the device to others: between the slices of a launch, and between stages.

A process that renders for many has `DEVICE_SHARING` ask its `Turns`. Alone, nothing is asked, and nothing waits.
"""

from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from os import cpu_count
from time import perf_counter, sleep
from typing import Protocol, TypeVar

WAIT_SECONDS = 0.002  # between two looks at whether something is done
Result = TypeVar("Result")
_threads = ThreadPoolExecutor(cpu_count() or 1, thread_name_prefix="beside")


class Turns(Protocol):
    """Who else wants the device."""

    def due(self, *, idle: bool = False) -> bool:
        """Whether somebody is to have it now: asked often, so it must take no time. idle: nothing is done with it."""

    def give(self) -> None:
        """Let others have it. Returns when the work is to go on; raises what is to end it."""

    def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
        """Let others have the host until what was begun is over; idle: or until they are to have the turn, too."""

    def holding(self, what: Hashable) -> AbstractContextManager[None]:
        """Have `what` for the work that runs; other work that comes for it waits, and lends it its turns."""


class DeviceSharing:
    """Asks for turns."""

    def __init__(self) -> None:
        self._turns: Turns | None = None
        self._kept = self._in_flight = 0
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
        if self.due:
            self._give()

    def wait_for(self, done: Callable[[], bool]) -> None:
        """Let others have the device until something that does not need it is done."""
        while not done():
            if self._turns is None or not self.active:
                sleep(WAIT_SECONDS)
                continue
            self._leave_until(done, idle=True)
            if self._turns.due(idle=True):
                self._give()

    def leave_until(self, over: Callable[[], bool]) -> None:
        """Let others have the host, and what the device has left, until what was launched is over.

        Alone: return at once.
        """
        if self.active:
            self._in_flight += 1
            try:
                self._leave_until(over)
            finally:
                self._in_flight -= 1

    def _leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
        assert self._turns is not None
        away = self._away_seconds
        try:
            self._turns.leave_until(over, idle=idle)
        finally:
            self._away_seconds = away  # that time is the work's own

    @property
    def in_flight(self) -> int:
        """Of how many jobs something is on the device that they have left the host for."""
        return self._in_flight

    def beside(self, work: Callable[[], Result]) -> Result:
        """What `work` returns, which is done in a thread while others have the device. It must not use a GPU."""
        if not self.active:
            return work()
        future = _threads.submit(work)
        try:
            self.wait_for(future.done)
        finally:
            future.cancel()  # who is interrupted waits for no end of what has begun: others want the host
        return future.result()

    @contextmanager
    def holding(self, what: Hashable) -> Iterator[None]:
        """Have `what` for the work that runs; other work that comes for it meanwhile waits, and lends it its turns:
        without, what is more urgent would for ever wait for what has none beside it. Alone: at once.
        """
        if self._turns is None:
            yield
            return
        away, begun = self._away_seconds, perf_counter()
        with self._turns.holding(what):
            self._away_seconds = away + perf_counter() - begun
            yield

    def _give(self) -> None:
        assert self._turns is not None
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

"""Jobs of a worker that others' jobs may interrupt: each has a stack of its own (greenlet), and one runs at a time.

Whoever serves the jobs says which goes on. One asks for its turn back when somebody waits; it ends at the next place
where it can be interrupted (gpu.core.sharing).
"""

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from threading import get_ident
from time import perf_counter

from greenlet import getcurrent, greenlet


class CancelledError(BaseException):
    """Nobody wants the job any more. Not an Exception, so that nothing but the end of the job catches it."""


class Task:
    """A job under way. waits_for: another one that has to end first."""

    def __init__(self, request: int, work: Callable[[], None]) -> None:
        self.request = request
        self.cancelled = False
        self.waits_for: Task | None = None
        self._stack = greenlet(work)

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._stack.dead

    def go_on(self) -> None:
        """Let it run until it ends or is interrupted."""
        self._stack.switch()


class Tasks:
    """The jobs under way; `turn_seconds` is what each may have at least of a turn."""

    def __init__(self, turn_seconds: float = 0.0) -> None:
        self.turn_seconds = turn_seconds
        self._tasks: dict[int, Task] = {}
        self._holders: dict[Hashable, Task | None] = {}
        self._current: Task | None = None
        self._turn, self._began = 0, 0.0  # the request whose turn it is, since when [s]
        self._asked = 0  # the request that is to give its turn back
        self._thread = get_ident()

    def start(self, request: int, work: Callable[[], None]) -> bool:
        """Begin a job; whether it has ended already. What it raises is raised here."""
        self._tasks[request] = Task(request, work)
        return self.resume(request)

    def resume(self, request: int) -> bool:
        """Go on with a job that was interrupted, or with what it waits for; whether it has ended."""
        task = self._tasks[request]
        runs = task
        while runs.waits_for is not None and not runs.waits_for.done:
            runs = runs.waits_for
        self._current, self._turn, self._began = runs, request, perf_counter()
        try:
            runs.go_on()
        finally:
            self._current = None
            if runs.done:
                self._tasks.pop(runs.request, None)
        return task.done

    def ask_back(self, request: int) -> None:
        """Somebody waits for the turn that a job has. From any thread."""
        self._asked = request

    def cancel(self, request: int) -> None:
        """Have a job end when it goes on. From any thread."""
        if (task := self._tasks.get(request)) is not None:
            task.cancelled = True

    @contextmanager
    def holding(self, what: Hashable) -> Iterator[None]:
        """Have `what` for the job that runs; one that comes for it meanwhile waits, and lends its turns."""
        while (holder := self._holders.get(what)) is not None and (task := self._current) is not None:
            task.waits_for = holder
            self._leave(task)
        self._holders[what] = self._current
        try:
            yield
        finally:
            del self._holders[what]

    def due(self, *, idle: bool = False) -> bool:
        """Whether the job that runs is to give its turn back now; idle: it has nothing to do with it."""
        task = self._current
        if task is None or get_ident() != self._thread:
            return False
        asked = self._asked == self._turn and (idle or perf_counter() - self._began >= self.turn_seconds)
        return asked or task.cancelled

    def give(self) -> None:
        """Leave the job that runs until it is resumed; CancelledError when nobody wants it any more."""
        task = self._current
        assert task is not None
        self._leave(task)

    def _leave(self, task: Task) -> None:
        self._asked = 0
        if not task.cancelled:
            parent = getcurrent().parent
            assert parent is not None
            parent.switch()
        if task.cancelled:
            raise CancelledError

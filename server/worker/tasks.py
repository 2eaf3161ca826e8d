"""Jobs of a worker that go on by turns: each has a stack of its own (greenlet), and one has the host at a time.

Whoever serves the jobs says which begins, and which that has given its turn back goes on. One is asked for its turn
when somebody waits; it ends at the next place where it can be interrupted (gpu.core.sharing). A job also leaves the
host, and keeps its turn, while what it launched is on the device, while another job has what it needs, and now and then
while others want the host: its turn is open then, and goes on by itself (`ready`).
"""

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from enum import Enum, auto
from threading import get_ident
from time import perf_counter

from greenlet import getcurrent, greenlet

# That a job has the host for, before others whose turns are open have it.
STINT_SECONDS = 0.005
# Between two looks at whether what a job waits for is over; and where that is nothing on the device.
POLL_SECONDS, IDLE_POLL_SECONDS = 0.00005, 0.002


class CancelledError(BaseException):
    """Nobody wants the job any more. Not an Exception, so that nothing but the end of the job catches it."""


class Turn(Enum):
    """What became of a job's turn when the job left the host."""

    OPEN = auto()  # it goes on once it is `ready`
    GIVEN_BACK = auto()  # it goes on in its next turn
    ENDED = auto()  # and so has the job


class Task:
    """A job under way. wants: what another one, waits_for, has to let go first; until: what has to be so before it goes
    on, in the turn of a request; idle: that needs no device.
    """

    def __init__(self, request: int, work: Callable[[], None]) -> None:
        self.request = request
        self.gives_back = False
        self.wants: Hashable = None
        self.waits_for: Task | None = None
        self.until: Callable[[int], bool] | None = None
        self.idle = False
        self._stack = greenlet(work)

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._stack.dead

    @property
    def first(self) -> "Task":
        """What has to go on first: it, or what it waits for."""
        return self if self.waits_for is None else self.waits_for.first

    def can_go_on(self, request: int) -> bool:
        """Whether it has something to do in the turn of a request."""
        return self.until is None or self.until(request)

    def go_on(self) -> None:
        """Let it run until it ends or leaves the host."""
        self._stack.switch()


class Tasks:
    """The jobs under way; `turn_seconds` is what each may have at least of a turn.

    others_wait: whether something else than open turns wants the host.
    """

    def __init__(self, turn_seconds: float = 0.0) -> None:
        self.turn_seconds = turn_seconds
        self.others_wait: Callable[[], bool] = lambda: False
        self._tasks: dict[int, Task] = {}
        self._holders: dict[Hashable, Task | None] = {}
        self._current: Task | None = None
        self._turn, self._stint_began = 0, 0.0  # the request whose turn it is, since when it has the host [s]
        self._turns: dict[int, float] = {}  # by request, those that have one and since when [s]; the last one last
        self._asked: set[int] = set()  # requests that are to give their turns back
        self._cancelled: set[int] = set()  # requests that are to end, though they may not have begun
        self._thread = get_ident()

    def start(self, request: int, work: Callable[[], None]) -> Turn:
        """Begin a job, whose request is a higher number than those before. What it raises is raised here."""
        self._tasks[request] = Task(request, work)
        for told in (self._asked, self._cancelled):
            for other in told.copy():
                if other < request and other not in self._tasks:  # it had ended when it was told
                    told.discard(other)
        return self.resume(request)

    def resume(self, request: int) -> Turn:
        """Go on with a job, or with what it waits for."""
        task = self._tasks[request]
        runs, now = task.first, perf_counter()
        self._turns[request] = self._turns.pop(request, now)
        if runs.can_go_on(request):
            self._current, self._turn, self._stint_began = runs, request, now
            try:
                runs.go_on()
            finally:
                self._current = None
                if runs.done:
                    self._tasks.pop(runs.request, None)
                    self._end_turn(runs.request)
        if task.done:
            return Turn.ENDED
        if runs.gives_back:
            runs.gives_back = False
            self._end_turn(request)
            return Turn.GIVEN_BACK
        return Turn.OPEN

    def waits(self, request: int) -> bool:
        """Whether a job under way waits for another that has a turn of its own."""
        first = self._tasks[request].first
        return first.request != request and first.request in self._turns

    def knows(self, request: int) -> bool:
        """Whether a job is under way."""
        return request in self._tasks

    @property
    def poll_seconds(self) -> float | None:
        """Until it is to be seen whether an open turn is `ready`; None where there is none."""
        if not self._turns:
            return None
        idle = all(self._tasks[request].first.idle for request in self._turns)
        return IDLE_POLL_SECONDS if idle else POLL_SECONDS

    def ready(self) -> int | None:
        """The request of an open turn that can go on, the one that did so longest ago; None while there is none."""
        return next((request for request in self._turns if self._is_ready(request)), None)

    def ask_back(self, request: int) -> None:
        """Somebody waits for the turn that a job has. From any thread."""
        self._asked.add(request)

    def cancel(self, request: int) -> None:
        """Have a job end when it goes on, or soon after it begins. From any thread."""
        self._cancelled.add(request)

    @contextmanager
    def holding(self, what: Hashable) -> Iterator[None]:
        """Have `what` for the job that runs; one that comes for it meanwhile waits, and lends its turns."""
        while (holder := self._holders.get(what)) is not None and (task := self._current) is not None:
            task.wants, task.waits_for = what, holder
            self._leave(task)
        self._holders[what] = self._current
        try:
            yield
        finally:
            del self._holders[what]
            for other in self._tasks.values():
                if other.wants == what:
                    other.wants = other.waits_for = None

    def due(self, *, idle: bool = False) -> bool:
        """Whether the job that runs is to leave the host now; idle: it has nothing to do with it."""
        task = self._current
        if task is None or get_ident() != self._thread:
            return False
        return self._is_cancelled(task) or self._is_asked(idle=idle) or self._is_wanted()

    def give(self) -> None:
        """Leave the job that runs until its turn comes again; CancelledError when nobody wants it any more."""
        task = self._current
        assert task is not None
        task.gives_back = self._turn in self._asked
        self._leave(task)

    def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
        """Leave the job that runs until what it began is over; idle: or its turn is asked back, or nobody wants it."""
        task = self._current
        if task is None:
            return

        def until(request: int) -> bool:
            return over() or (idle and (self._is_cancelled(task) or request in self._asked))

        task.until, task.idle = until, idle
        try:
            if not until(self._turn):
                self._switch()
        finally:
            task.until, task.idle = None, False

    def _is_cancelled(self, task: Task) -> bool:
        return task.request in self._cancelled

    def _is_asked(self, *, idle: bool) -> bool:
        return self._turn in self._asked and (idle or perf_counter() - self._turns[self._turn] >= self.turn_seconds)

    def _is_wanted(self) -> bool:
        """Whether others whose turns are open, or that have not begun, want the host."""
        if perf_counter() - self._stint_began < STINT_SECONDS:
            return False
        return self.others_wait() or any(self._is_ready(other) for other in self._turns if other != self._turn)

    def _is_ready(self, request: int) -> bool:
        runs = self._tasks[request].first
        return runs is not self._current and not self.waits(request) and runs.can_go_on(request)

    def _end_turn(self, request: int) -> None:
        self._turns.pop(request, None)
        self._asked.discard(request)

    def _leave(self, task: Task) -> None:
        if not self._is_cancelled(task):
            self._switch()
        if self._is_cancelled(task):
            raise CancelledError

    def _switch(self) -> None:
        parent = getcurrent().parent
        assert parent is not None
        parent.switch()

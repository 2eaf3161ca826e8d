"""The web process's side of rendering: keeps a worker running and gives it one job at a time, in turn.

Whoever wants something rendered waits for a turn, which `Schedule` gives. A job is made when its turn comes, not
before: a viewer's pose is then the newest one. More devices will mean more engines, one worker each, and viewers shared
out among them.
"""

import asyncio
import itertools
import logging
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from time import monotonic

from gpu.errors import OutOfMemoryError, UserError
from server.link import Link, WorkerLostError
from server.messages import (
    START_UP,
    STILLS,
    Cause,
    Done,
    Failed,
    Free,
    Job,
    Leave,
    Opened,
    OpenScene,
    Progress,
    Ready,
    SceneRef,
    Start,
)
from server.protocol import SceneInfo
from server.schedule import Place, Schedule, Urgency

WORKER = (sys.executable, "-m", "server.backend")
BACKOFF_SECONDS = (0.1, 0.5, 1.0, 2.0, 5.0, 10.0)
SETTLED_SECONDS = 60.0  # a worker that lived this long does not count as failing again and again
log = logging.getLogger("lumenwalk.engine")


class EngineState(StrEnum):
    """Whether frames can be had."""

    STARTING = "starting"
    READY = "ready"
    RECOVERING = "recovering"
    FAILED = "failed"


@dataclass(frozen=True)
class Activity:
    """What the engine is doing: its state and, while something takes long, what and how far it is."""

    state: EngineState
    text: str = ""
    fraction: float = 0.0


RECOVERING = Activity(EngineState.RECOVERING, "starting the renderer again")


class RenderFaultError(Exception):
    """A job failed by the program's fault."""


_ERRORS: dict[Cause, type[Exception]] = {
    Cause.USER: UserError,
    Cause.MEMORY: OutOfMemoryError,
    Cause.PROGRAM: RenderFaultError,
}
Reply = tuple[Done | Opened, bytes]
Make = Callable[[], Job | None]


@dataclass(frozen=True)
class _Waiting:
    """What is to be done when a turn comes, and who is to be told."""

    make: Make
    turn: "asyncio.Future[asyncio.Future[Reply] | None]"


@dataclass(frozen=True)
class _Running:
    """The job that the worker has."""

    request: int
    place: Place
    began: float  # [s]


class Engine:
    """One worker process, restarted when it dies, and the queue to it."""

    def __init__(self, start: Start, command: Sequence[str] = WORKER) -> None:
        self._start = start
        self._command = command
        self._activity = Activity(EngineState.STARTING, "starting")
        self._link: Link | None = None
        self._schedule = Schedule()
        self._waiting: dict[Place, _Waiting] = {}
        self._numbers = itertools.count(1)
        self._listening = False  # the worker takes jobs
        self._running: _Running | None = None
        self._owed: dict[int, asyncio.Future[Reply]] = {}
        self.restarts = 0
        self.device = ""
        self.listeners: set[Callable[[], None]] = set()

    @property
    def activity(self) -> Activity:
        """What the engine is doing now; `listeners` are called when it changes."""
        return self._activity

    @property
    def ready(self) -> bool:
        """Whether jobs are taken now."""
        return self._activity.state is EngineState.READY

    @property
    def worker_pid(self) -> int | None:
        """Process id of the worker, if one runs."""
        return self._link.pid if self._link else None

    async def run(self) -> None:
        """Keep a worker running until cancelled, or until the first one fails by the user's fault (state FAILED)."""
        failures = 0
        while True:
            began = monotonic()
            try:
                await self._live()
            except UserError as error:
                if self.restarts == 0:
                    self._tell(Activity(EngineState.FAILED, str(error)))
                    return
                log.error("the worker cannot start again: %s", error)
            except WorkerLostError as error:
                log.error("%s", error)
            except Exception:
                log.exception("the worker is started again after a fault in the web process")
            failures = 0 if monotonic() - began > SETTLED_SECONDS else failures + 1
            self.restarts += 1
            self._tell(RECOVERING)
            await asyncio.sleep(BACKOFF_SECONDS[min(failures, len(BACKOFF_SECONDS)) - 1] if failures else 0.0)

    async def submit(self, client: int, urgency: Urgency, make: Make) -> "asyncio.Future[Reply] | None":
        """Wait for a turn, then send the job that `make` returns then, and return the future of its answer.

        client: the viewer's number, or STILLS. Returns None when `make` does, which gives the turn away and costs
        nothing. The future ends with the answer and its bytes, or with UserError (the job was wrong), OutOfMemoryError,
        RenderFaultError (a bug) or WorkerLostError.
        """
        place = self._schedule.join(client, urgency)
        waiting = self._waiting[place] = _Waiting(make, asyncio.get_running_loop().create_future())
        self._give_turns()
        try:
            return await waiting.turn
        finally:
            self._schedule.leave(place)
            self._waiting.pop(place, None)

    async def open(self, scene: SceneRef) -> SceneInfo:
        """Load a scene and say what is in it; errors as the futures of `submit`."""
        reply = await self.submit(STILLS, Urgency.STILL, lambda: OpenScene(scene))
        if reply is None:
            raise WorkerLostError("the worker is gone")
        answer, _ = await reply
        assert isinstance(answer, Opened)
        return answer.info

    def leave(self, viewer: int) -> None:
        """Free what the worker keeps for a viewer."""
        if self._link is not None:
            self._link.send(Leave(viewer))

    async def _live(self) -> None:
        self._link = link = await Link.start(self._command)
        try:
            link.send(self._start)
            while True:
                message, payload = await link.receive()
                match message:
                    case Ready(device):
                        self.device = device
                        self._listening = True
                        self._tell(Activity(EngineState.READY))
                        self._give_turns()
                    case Progress(text, fraction):
                        self._tell(Activity(self._activity.state, text, fraction))
                    case Free(request, busy_ms) if self._running and request == self._running.request:
                        self._end_turn(busy_ms / 1e3)
                        self._tell(Activity(EngineState.READY))
                        self._give_turns()
                    case Failed(request, text, cause):
                        error = _ERRORS[cause](text)
                        if request == START_UP:
                            raise (
                                error
                                if cause is not Cause.PROGRAM
                                else WorkerLostError(f"worker {link.pid} could not start")
                            )
                        self._settle(request, error)
                    case Opened(request) | Done(request):
                        self._settle(request, (message, payload))
        finally:
            self._link = None
            self._listening = False
            if self.ready:  # before anyone learns of a lost job: who asks at once must not be told to go on
                self._tell(RECOVERING)
            if self._running is not None:
                self._end_turn(monotonic() - self._running.began)
            for request in list(self._owed):
                self._settle(request, WorkerLostError("the renderer was lost; it is being started again"))
            status = await link.stop()
            log.info("worker %d ended with status %d", link.pid, status)

    def _give_turns(self) -> None:
        while self._listening and self._running is None and (place := self._schedule.next()) is not None:
            waiting = self._waiting[place]
            if waiting.turn.done():  # who asked has left this instant
                continue
            try:
                job = waiting.make()
            except Exception as error:
                waiting.turn.set_exception(error)
            else:
                waiting.turn.set_result(None if job is None else self._send(place, job))

    def _send(self, place: Place, job: Job) -> "asyncio.Future[Reply]":
        assert self._link is not None
        self._running = _Running(next(self._numbers), place, monotonic())
        reply = self._owed[self._running.request] = asyncio.get_running_loop().create_future()
        self._link.send(replace(job, request=self._running.request))
        return reply

    def _end_turn(self, seconds: float) -> None:
        assert self._running is not None
        self._schedule.charge(self._running.place, seconds)
        self._running = None

    def _settle(self, request: int, result: Reply | Exception) -> None:
        future = self._owed.pop(request, None)
        if future is None or future.done():  # whoever asked has left
            return
        if isinstance(result, Exception):
            future.set_exception(result)
            future.exception()  # marks it as seen: nobody may be left to look
        else:
            future.set_result(result)

    def _tell(self, activity: Activity) -> None:
        if activity == self._activity:
            return
        self._activity = activity
        for listener in tuple(self.listeners):
            listener()

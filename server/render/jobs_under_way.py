"""The jobs of an engine, from who waits for a turn to the worker's answer.

Whoever wants something rendered waits for a turn, which `Schedule` gives. A job is made when its turn comes, not
before: a viewer's pose is then the newest one. A job whose turn is long is asked to give it back when others wait, and
queues up again for the rest.
"""

import asyncio
import itertools
import logging
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import monotonic
from typing import TypeAlias

from server.render.activity import READY, RECOVERING
from server.render.asking_back import AskingBack
from server.render.cost import Speeds
from server.render.heartbeat import heartbeat, is_warm
from server.render.pending import ERRORS, Answer, PendingJob, Reply
from server.render.quarantine import Quarantine, QuarantinedError
from server.render.running import RunningTurn, RunningTurns
from server.render.schedule import QueueEntry, Schedule, Urgency
from server.render.standing import NOTHING, Standing
from server.render.worker_link import InnocentLossError, TurnedAwayError, WorkerLink, WorkerLostError
from server.wire.worker import (
    HEARTBEAT,
    Cancel,
    Cause,
    Closed,
    Done,
    Exported,
    Failed,
    Free,
    FromWorker,
    Job,
    Opened,
    Paused,
    Picked,
    Render,
    Resume,
    SceneRef,
    Yield,
)

HEARTBEAT_DEADLINE = 5.0  # to render one pixel of what was rendered before [s]
LOST = "the renderer was lost; it is being started again"
log = logging.getLogger("lumenwalk.engine")

Make = Callable[[], Job | None]
Turn: TypeAlias = asyncio.Future[asyncio.Future[Reply] | None]


@dataclass(frozen=True)
class _Waiting:
    """What is to be done when a turn comes, and who is to be told; elsewhere: has another engine give the turn."""

    make: Make
    turn: Turn
    elsewhere: Callable[[], None] | None = None


class JobsUnderWay:
    """Who waits, which jobs a worker has and which of them pause; a worker takes them from `take` to `settle`."""

    def __init__(
        self, standing: Standing, served: SceneRef, hang_seconds: float, quarantine: Quarantine, speeds: Speeds
    ) -> None:
        """standing: of their engine; served: the scene that every worker has; hang_seconds: how long nothing may be
        said during a job.
        """
        self.hang_seconds = hang_seconds
        self.running = RunningTurns()
        self._standing, self._served = standing, served
        self._quarantine, self._speeds = quarantine, speeds
        self._link: WorkerLink | None = None  # to a worker that takes jobs
        self._schedule = Schedule()
        self._waiting: dict[QueueEntry, _Waiting] = {}
        self._numbers = itertools.count(1)
        self._paused: dict[QueueEntry, RunningTurn] = {}  # what has more turns to come
        self._pending: dict[int, PendingJob] = {}
        self._asking_back = AskingBack(self.running, lambda: (*self._waiting, *self._paused), self._ask_back, standing)
        self._last_rendered: Render | None = None  # what was rendered last

    @property
    def taken(self) -> bool:
        """Whether a worker takes jobs."""
        return self._link is not None

    @property
    def waiting(self) -> Counter[Urgency]:
        """How many jobs wait for a turn, by urgency."""
        return Counter(entry.urgency for entry in (*self._waiting, *self._paused))

    def queued(self, client: int) -> int:
        """How many jobs of a client wait or run."""
        running = (turn.entry for turn in self.running)
        return sum(entry.client == client for entry in (*self._waiting, *self._paused, *running))

    @property
    def most_bytes(self) -> int:
        """That an answer may have now."""
        return max((pending.most_bytes for pending in self._pending.values()), default=0)

    # --- who waits ---

    def submit(
        self, client: int, urgency: Urgency, make: Make, turn: Turn, elsewhere: Callable[[], None] | None
    ) -> None:
        """As `Engine.submit`."""
        entry = self._enqueue(client, urgency, _Waiting(make, turn, elsewhere))
        turn.add_done_callback(lambda _: self._leave_queue(entry) if turn.cancelled() else None)

    def turn_away(self) -> None:
        """Another engine is ready, and this one is not: who waits for a turn is to go there."""
        for entry, waiting in tuple(self._waiting.items()):
            if entry.client != HEARTBEAT and not waiting.turn.done():
                self._leave_queue(entry)
                if waiting.elsewhere is not None:
                    waiting.elsewhere()
                    continue
                waiting.turn.set_exception(TurnedAwayError("another renderer is ready"))
                waiting.turn.exception()  # marks it as seen: who waits may have left this instant

    def queue_heartbeat(self) -> None:
        """See whether the worker still renders, unless that waits for its turn already."""
        if all(entry.client != HEARTBEAT for entry in self._waiting):
            turn = asyncio.get_running_loop().create_future()
            self._enqueue(HEARTBEAT, Urgency.REFINING, _Waiting(self._heartbeat, turn))

    def _heartbeat(self) -> Job:
        return heartbeat(self._last_rendered, self._standing.scenes, self._served)

    def _enqueue(self, client: int, urgency: Urgency, waiting: _Waiting) -> QueueEntry:
        entry = self._schedule.join(client, urgency)
        self._waiting[entry] = waiting
        self._dispatch()
        self._asking_back.look()
        return entry

    def _leave_queue(self, entry: QueueEntry) -> None:
        self._schedule.leave(entry)
        self._waiting.pop(entry, None)

    # --- whose turn it is ---

    def take(self, link: WorkerLink, lanes: int) -> None:
        """A worker takes jobs from now on, so many at once."""
        self._link, self.running.lanes = link, lanes
        self._quarantine.renew()
        self._standing.set_activity(READY)
        self._dispatch()
        self.queue_heartbeat()

    def _dispatch(self) -> None:
        self.running.alone = self._quarantine.suspecting or (self.running.alone and len(self.running) > 0)
        if self._link is not None:
            with self._link.together():
                self._give_turns(self._link)

    def _give_turns(self, link: WorkerLink) -> None:
        while not self.running.full:
            if (entry := self._schedule.next(self.running.admit)) is None:
                break
            if (paused := self._paused.pop(entry, None)) is not None:
                turn = replace(paused, began=monotonic(), asked_back=False)
                self._begin_turn(link, turn, Resume(paused.request))
                continue
            waiting = self._waiting.pop(entry)
            if waiting.turn.done():  # who asked has left this instant
                continue
            try:
                job = waiting.make()
            except Exception as error:
                waiting.turn.set_exception(error)
            else:
                waiting.turn.set_result(None if job is None else self._send(link, entry, job))

    def _send(self, link: WorkerLink, entry: QueueEntry, job: Job) -> "asyncio.Future[Reply]":
        reply: asyncio.Future[Reply] = asyncio.get_running_loop().create_future()
        try:
            self._quarantine.check(job, cuda=self._standing.cuda)
        except QuarantinedError as error:
            PendingJob(job, reply).resolve(error)
            return reply
        quick = entry.client == HEARTBEAT and is_warm(self._last_rendered, self._standing.scenes)
        patience = HEARTBEAT_DEADLINE if quick else self.hang_seconds
        request = next(self._numbers)
        self._pending[request] = PendingJob(job, reply)
        reply.add_done_callback(lambda _: self._cancel(request) if reply.cancelled() else None)
        turn = RunningTurn(request, entry, job, monotonic(), patience)
        self._begin_turn(link, turn, replace(job, request=request))
        return reply

    def _begin_turn(self, link: WorkerLink, turn: RunningTurn, message: Job | Resume) -> None:
        self.running.begin(turn)
        link.send(message)
        self._asking_back.begun(turn)

    def ask_back_since(self, began: float) -> None:
        """Ask turns back that began then [s] or before, whoever waits."""
        for turn in self.running:
            if turn.began <= began:
                self._ask_back(turn)

    def _ask_back(self, turn: RunningTurn) -> None:
        if self._link is not None and not turn.asked_back:
            turn.asked_back = True
            self._link.send(Yield(turn.request))

    def _cancel(self, request: int) -> None:
        """Nobody wants this job any more."""
        if self._link is not None and request in self._pending:
            self._link.send(Cancel(request))

    def _end_turn(self, turn: RunningTurn, busy_seconds: float) -> float:
        """A turn has ended that had the device for so long, as the worker says; how long it can have been [s]."""
        seconds = min(busy_seconds, monotonic() - turn.began)
        self._schedule.charge(turn.entry, seconds)
        self._standing.busy_seconds += seconds
        self.running.end(turn)
        return seconds

    # --- what the worker says of them ---

    def hear(self, link: WorkerLink, message: FromWorker, payload: bytes) -> None:
        """What the worker says of its jobs; WorkerLostError, and its end, where it says that of none."""
        match message:
            case Failed(request, text, cause) if request in self._pending:
                if cause is Cause.PROGRAM and (turn := self.running.get(request)) and turn.is_heartbeat:
                    raise link.refuse("word that it can render no more")
                pending = self._pending.pop(request)
                if cause is not Cause.PROGRAM and not pending.reply.cancelled():  # its own mistake, found in time
                    self._quarantine.acquit(pending.job)
                pending.resolve(ERRORS[cause](text))
            case Done() | Opened() | Closed() | Picked() | Exported() if self._answers(message):
                pending = self._pending.pop(message.request)
                if isinstance(pending.job, Render) and isinstance(message, Done):
                    self._last_rendered = pending.job
                    self._speeds.learn(pending.job, message.render_ms / 1e3, cuda=self._standing.cuda)
                self._quarantine.acquit(pending.job)
                pending.resolve((message, payload))
            case Free(request) if turn := self.running.get(request):
                self._standing.holds(message.holdings)
                self._end_turn(turn, message.busy_ms / 1e3)
                self._standing.set_activity(READY)
                # Whoever has just been told of a failure says first whether he still wants what he waits for.
                asyncio.get_running_loop().call_soon(self._dispatch)
            case Free(request) if paused := self._paused_job(request):  # it ended in the turn of one that waited for it
                self._schedule.leave(paused)
                del self._paused[paused]
            case Paused(request) if turn := self.running.get(request):
                self._standing.holds(message.holdings)
                seconds = self._end_turn(turn, message.busy_ms / 1e3)
                self._schedule.rejoin(turn.entry)
                self._paused[turn.entry] = replace(turn, spent=turn.spent + seconds)
                self._dispatch()
            case _:
                raise link.refuse(f"{message.kind} out of turn")

    def _paused_job(self, request: int) -> QueueEntry | None:
        return next((entry for entry, paused in self._paused.items() if paused.request == request), None)

    def _answers(self, answer: Answer) -> bool:
        return answer.request in self._pending and self._pending[answer.request].answered_by(answer)

    async def settle(self, link: WorkerLink, *, hung: bool) -> None:
        """The worker at a link is gone: end it and its turns, tell whoever waits for its answers, and blame its job.

        hung: it was killed because it said nothing.
        """
        self._link = self._last_rendered = None
        self._standing.holds(NOTHING)
        if self._standing.ready:  # before anyone learns of a lost job: who asks at once must not be told to go on
            self._standing.set_activity(RECOVERING)
        running, now = tuple(self.running), monotonic()
        for entry in self._paused:
            self._schedule.leave(entry)
        self._paused.clear()
        for turn in running:
            self._end_turn(turn, (now - turn.began) / len(running))
        guilty = self._pending.pop(running[0].request, None) if len(running) == 1 else None
        for request in list(self._pending):
            self._pending.pop(request).resolve(InnocentLossError(LOST))
        try:
            status = await link.stop()
            if len(running) == 1:
                spent = running[0].spent + now - running[0].began
                self._quarantine.blame(running[0].job, spent, status, hung=hung)
            else:
                self._quarantine.suspect(turn.job for turn in running)
            log.info("worker %d ended with status %s", link.pid, status)
        finally:  # it may be tried on another engine at once, which must know what it has done
            if guilty is not None:
                guilty.resolve(WorkerLostError(LOST))

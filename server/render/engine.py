"""The web process's side of rendering: keeps a worker running and gives it jobs in turn, as many at once as it has
lanes.

Whoever wants something rendered waits for a turn, which `Schedule` gives. A job is made when its turn comes, not
before: a viewer's pose is then the newest one. A job whose turn is long is asked to give it back when others wait, and
queues up again for the rest. More devices mean more engines, with one worker each (server.render.engine_pool).

A worker that ends, sends what it should not, or says nothing for too long is replaced. While nobody wants anything, one
pixel of what was rendered last is rendered every few seconds, to see whether it still can be.
"""

import asyncio
import itertools
import logging
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf
from time import monotonic
from typing import TypeAlias

from gpu.errors import UserError
from server.render.activity import READY, RECOVERING, Activity, EngineState
from server.render.cost import Speeds
from server.render.heartbeat import heartbeat, is_warm
from server.render.pending import ERRORS, Answer, PendingJob, Reply
from server.render.quarantine import Quarantine, QuarantinedError
from server.render.running import RunningTurn, RunningTurns
from server.render.schedule import QueueEntry, Schedule, Urgency
from server.render.worker_link import InnocentLossError, TurnedAwayError, WorkerLink, WorkerLostError
from server.render.worker_process import WORKER
from server.render.workers import Workers
from server.wire.browser import SceneInfo
from server.wire.worker import (
    HEARTBEAT,
    START_UP,
    STILLS,
    Cancel,
    Cause,
    Closed,
    CloseScene,
    Done,
    Exported,
    Failed,
    Free,
    FromWorker,
    Holdings,
    Job,
    Leave,
    Opened,
    OpenScene,
    Paused,
    Picked,
    Progress,
    Ready,
    Render,
    Resume,
    SceneRef,
    Start,
    Yield,
)

# Before a new worker is started, by how many have ended since one was ready; one that was ready is replaced at once.
BACKOFF_SECONDS = (0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0)
FIRST_WORD_SECONDS = 60.0  # until a worker says its first word: it has to import what takes messages
START_SECONDS = 600.0  # that a worker may say nothing after that: it imports what renders, and may compile all of it
MOST_STARTS = 5  # of workers in a row before one has ever been ready: what stops them does not go away
OVERDUE_SECONDS = 5.0  # without a word, after which a turn takes too long for others
TURN_SECONDS = 30.0  # after which it does so in any case
HEARTBEAT_SECONDS = 5.0  # between two words from a worker without a job
HEARTBEAT_DEADLINE = 5.0  # to render one pixel of what was rendered before [s]
MOST_TURN_SECONDS = 300.0  # of a turn, whatever it says, unless it may be silent for longer: others wait for it
LONG_TURN_SECONDS = 1.0  # after which a turn is asked back, whoever waits: so the worker says that it lives
WATCH_SECONDS = 0.2  # between two looks at how long a worker has been silent
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


class Engine:
    """One worker process, restarted when it dies, and the queue to it."""

    def __init__(
        self,
        start: Start,
        command: Sequence[str] = WORKER,
        hang_seconds: float = 120.0,
        quarantine: Quarantine | None = None,
        speeds: Speeds | None = None,
    ) -> None:
        """hang_seconds: how long a worker with a job, which may have kernels to compile, may say nothing before it is
        replaced; quarantine, speeds: shared with other engines.
        """
        self.workers = Workers(command, start)
        self._hang_seconds = hang_seconds
        self._activity = Activity(EngineState.STARTING, "starting")
        self._link: WorkerLink | None = None
        self._schedule = Schedule()
        self._waiting: dict[QueueEntry, _Waiting] = {}
        self._numbers = itertools.count(1)
        self._listening = False  # the worker takes jobs
        self._running = RunningTurns()
        self._asks_later: asyncio.Handle | None = None
        self._asks_at = inf  # and when [s]; handles of loops other than asyncio's own do not tell
        self._all_short_until = inf  # before which no turn that was not asked back can be [s]
        self._paused: dict[QueueEntry, RunningTurn] = {}  # what has more turns to come
        self._pending: dict[int, PendingJob] = {}
        self._last_heard = 0.0  # when the worker last said something, or was told to start [s]
        self._last_rendered: Render | None = None  # what was rendered last
        self._quarantine = quarantine or Quarantine()
        self._speeds = speeds or Speeds()
        self._hung = False  # the worker was killed because it said nothing
        self._spoken = False  # the worker has said something
        self._was_ready = False  # a worker was, since the service began
        self._failures = 0  # workers that ended since one was ready
        self.restarts = 0
        self.unusable = False  # no worker can start, by the user's fault
        self.device = ""
        self.busy_seconds = 0.0  # of device time, by all workers together
        self.memory = (0, 0)  # of the device: used and all [bytes]; not known before it is ready
        self.scenes: tuple[SceneRef, ...] = ()  # on the device, the one used last at the end
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
    def cuda(self) -> bool:
        """Whether the worker has a GPU, as far as it has said so."""
        return "cuda" in self.device

    @property
    def overdue(self) -> str:
        """What keeps the worker from others for too long, in words, if anything does."""
        began, now = self._running.began, monotonic()
        if self._link is None or (self._listening and began is None):
            return ""
        turn = now - began if began is not None else 0.0
        silence = now - max(self._last_heard, began or 0.0)
        if silence > OVERDUE_SECONDS:
            return f"the renderer has said nothing for {silence:.0f} s"
        return f"one job has had the renderer for {turn:.0f} s" if turn > TURN_SECONDS else ""

    @property
    def waiting(self) -> Counter[Urgency]:
        """How many jobs wait for a turn, by urgency."""
        return Counter(entry.urgency for entry in (*self._waiting, *self._paused))

    @property
    def max_scenes(self) -> int:
        """That the worker keeps at the same time."""
        return self.workers.start.max_scenes

    def queued(self, client: int) -> int:
        """How many jobs of a client wait or run."""
        running = (turn.entry for turn in self._running)
        return sum(entry.client == client for entry in (*self._waiting, *self._paused, *running))

    @property
    def worker_pid(self) -> int | None:
        """Process id of the worker, if one runs."""
        return self._link.pid if self._link else None

    async def run(self) -> None:
        """Keep a worker running until cancelled, or until none can be started (state FAILED): by the user's fault, or
        because MOST_STARTS in a row have ended before one was ready.
        """
        while True:
            try:
                await self._run_worker()
            except UserError as error:
                if not self._was_ready:
                    self.unusable = True
                    self._set_activity(Activity(EngineState.FAILED, str(error)))
                    return
                log.error("the worker cannot start again: %s", error)
            except WorkerLostError as error:
                log.error("%s", error)
                if not self._was_ready and self._failures + 1 >= MOST_STARTS:
                    text = f"the renderer could not be started, {MOST_STARTS} times; the last: {error}"
                    self._set_activity(Activity(EngineState.FAILED, text))
                    return
            except Exception:
                log.exception("the worker is started again after a fault in the web process")
            pause = BACKOFF_SECONDS[min(self._failures, len(BACKOFF_SECONDS) - 1)]
            self._failures += 1
            self.restarts += 1
            self._set_activity(RECOVERING)
            await asyncio.sleep(pause)

    def submit(
        self,
        client: int,
        urgency: Urgency,
        make: Make,
        turn: Turn | None = None,
        elsewhere: Callable[[], None] | None = None,
    ) -> Turn:
        """The future of a turn, in which the job is sent that `make` returns then, and of its answer; who cancels it
        leaves.

        client: the viewer's number, or STILLS. There is no answer when `make` returns None, which gives the turn away
        and costs nothing. Else it is the answer and its bytes, or UserError (the job was wrong), OutOfMemoryError,
        RenderFaultError (a bug) or WorkerLostError. turn: the future, where there is one; elsewhere: has another engine
        give it, when that is ready and this one is not; without, the turn ends with TurnedAwayError then.
        """
        turn = turn or asyncio.get_running_loop().create_future()
        entry = self._enqueue(client, urgency, _Waiting(make, turn, elsewhere))
        turn.add_done_callback(lambda _: self._leave_queue(entry) if turn.cancelled() else None)
        return turn

    def _leave_queue(self, entry: QueueEntry) -> None:
        self._schedule.leave(entry)
        self._waiting.pop(entry, None)

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

    async def open(self, scene: SceneRef, packed: str = "") -> SceneInfo:
        """Load a scene, `packed` if it was read already, and say what is in it; errors as the futures of `submit`."""
        answer = await self._answer_to(OpenScene(scene, packed=packed))
        assert isinstance(answer, Opened)
        return answer.info

    async def close(self, scene: SceneRef) -> None:
        """Free a scene and all that was made for it; errors as the futures of `submit`."""
        await self._answer_to(CloseScene(scene))

    async def _answer_to(self, job: Job) -> Answer:
        reply = await self.submit(STILLS, Urgency.STILL, lambda: job)
        assert reply is not None  # there was a job
        answer, _ = await reply
        return answer

    def leave(self, viewer: int) -> None:
        """Free what the worker keeps for a viewer."""
        if self._link is not None:
            self._link.send(Leave(viewer))

    async def _run_worker(self) -> None:
        self._link = link = await WorkerLink.to(self.workers.new())
        self._hung = self._spoken = False
        self._last_heard = monotonic()
        watch = asyncio.create_task(self._watch(link), name="watch")
        try:
            while True:
                message, payload = await link.receive(self._most_bytes)
                self._last_heard, self._spoken = monotonic(), True
                self._handle(link, message, payload)
        finally:
            watch.cancel()
            await self._settle(link)

    async def _settle(self, link: WorkerLink) -> None:
        """The worker at a link is gone: end it and its turns, tell whoever waits for its answers, and blame its job."""
        self._link = None
        self._listening = False
        self._last_rendered = None
        self.memory, self.scenes = (0, 0), ()
        if self.ready:  # before anyone learns of a lost job: who asks at once must not be told to go on
            self._set_activity(RECOVERING)
        running, now = tuple(self._running), monotonic()
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
                self._quarantine.blame(running[0].job, spent, status, hung=self._hung)
            else:
                self._quarantine.suspect(turn.job for turn in running)
            log.info("worker %d ended with status %s", link.pid, status)
        finally:  # it may be tried on another engine at once, which must know what it has done
            if guilty is not None:
                guilty.resolve(WorkerLostError(LOST))

    def _handle(self, link: WorkerLink, message: FromWorker, payload: bytes) -> None:
        match message:
            case Progress(text, fraction):
                self._set_activity(Activity(self._activity.state, text, fraction))
            case Ready(device) if not self._listening:
                self.device, self._running.lanes = device, message.lanes
                self._take_note_of(message.holdings)
                self._failures, self._listening, self._was_ready = 0, True, True
                self._quarantine.renew()
                self._set_activity(READY)
                self._dispatch()
                self._queue_heartbeat()
            case Failed(request, text, cause) if request == START_UP and not self._listening:
                if cause is Cause.PROGRAM:
                    raise WorkerLostError(f"worker {link.pid} could not start")
                raise ERRORS[cause](text)
            case Failed(request, text, cause) if request in self._pending:
                if cause is Cause.PROGRAM and (turn := self._running.get(request)) and turn.is_heartbeat:
                    raise link.refuse("word that it can render no more")
                self._pending.pop(request).resolve(ERRORS[cause](text))
            case Done() | Opened() | Closed() | Picked() | Exported() if self._answers(message):
                pending = self._pending.pop(message.request)
                if isinstance(pending.job, Render) and isinstance(message, Done):
                    self._last_rendered = pending.job
                    self._speeds.learn(pending.job, message.render_ms / 1e3, cuda=self.cuda)
                self._quarantine.acquit(pending.job)
                pending.resolve((message, payload))
            case Free(request) if turn := self._running.get(request):
                self._take_note_of(message.holdings)
                self._end_turn(turn, message.busy_ms / 1e3)
                self._set_activity(READY)
                # Whoever has just been told of a failure says first whether he still wants what he waits for.
                asyncio.get_running_loop().call_soon(self._dispatch)
            case Free(request) if paused := self._paused_job(request):  # it ended in the turn of one that waited for it
                self._schedule.leave(paused)
                del self._paused[paused]
            case Paused(request) if turn := self._running.get(request):
                self._take_note_of(message.holdings)
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

    def _take_note_of(self, holdings: Holdings) -> None:
        self.memory, self.scenes = (holdings.memory_used, holdings.memory_total), holdings.scenes

    def _most_bytes(self) -> int:
        return max((pending.most_bytes for pending in self._pending.values()), default=0)

    async def _watch(self, link: WorkerLink) -> None:
        """Kill a worker that hangs, which `_run_worker` then hears; have an idle one show that it lives."""
        while True:
            due = monotonic() + WATCH_SECONDS
            await asyncio.sleep(WATCH_SECONDS)
            began, now = self._running.began, monotonic()
            self._last_heard = min(max(self._last_heard, began or 0.0) + now - due, now)  # but for what it slept longer
            silence = now - self._last_heard
            if self._listening and began is None:
                if silence >= HEARTBEAT_SECONDS:
                    self._queue_heartbeat()
                continue
            starting = START_SECONDS if self._spoken else FIRST_WORD_SECONDS
            if silence >= (starting if began is None else self._running.patience):
                log.error("worker %d has said nothing for %.1f s: it hangs and is killed", link.pid, silence)
            elif began is not None and now - began >= max(MOST_TURN_SECONDS, self._hang_seconds):
                log.error("worker %d has been at one job for %.0f s: it is killed", link.pid, now - began)
            else:
                for turn in self._running:
                    if now - turn.began >= LONG_TURN_SECONDS:
                        self._ask_back(turn)
                continue
            self._hung = True
            link.kill()

    def _queue_heartbeat(self) -> None:
        if all(entry.client != HEARTBEAT for entry in self._waiting):
            turn = asyncio.get_running_loop().create_future()
            self._enqueue(HEARTBEAT, Urgency.REFINING, _Waiting(self._heartbeat, turn))

    def _heartbeat(self) -> Job:
        return heartbeat(self._last_rendered, self.scenes, self.workers.start.scene)

    def _enqueue(self, client: int, urgency: Urgency, waiting: _Waiting) -> QueueEntry:
        entry = self._schedule.join(client, urgency)
        self._waiting[entry] = waiting
        self._dispatch()
        self._ask_back_for_others()
        return entry

    def _dispatch(self) -> None:
        self._running.alone = self._quarantine.suspecting or (self._running.alone and len(self._running) > 0)
        while self._listening and not self._running.full:
            if (entry := self._schedule.next(self._running.admit)) is None:
                break
            if (paused := self._paused.pop(entry, None)) is not None:
                self._begin_turn(replace(paused, began=monotonic(), asked_back=False), Resume(paused.request))
                continue
            waiting = self._waiting.pop(entry)
            if waiting.turn.done():  # who asked has left this instant
                continue
            try:
                job = waiting.make()
            except Exception as error:
                waiting.turn.set_exception(error)
            else:
                waiting.turn.set_result(None if job is None else self._send(entry, job))

    def _send(self, entry: QueueEntry, job: Job) -> "asyncio.Future[Reply]":
        reply: asyncio.Future[Reply] = asyncio.get_running_loop().create_future()
        try:
            self._quarantine.check(job, cuda=self.cuda)
        except QuarantinedError as error:
            PendingJob(job, reply).resolve(error)
            return reply
        quick = entry.client == HEARTBEAT and is_warm(self._last_rendered, self.scenes)
        patience = HEARTBEAT_DEADLINE if quick else self._hang_seconds
        request = next(self._numbers)
        self._pending[request] = PendingJob(job, reply)
        reply.add_done_callback(lambda _: self._cancel(request) if reply.cancelled() else None)
        self._begin_turn(RunningTurn(request, entry, job, monotonic(), patience), replace(job, request=request))
        return reply

    def _begin_turn(self, turn: RunningTurn, message: Job | Resume) -> None:
        assert self._link is not None
        self._running.begin(turn)
        self._link.send(message)
        free = turn.free_at(cuda=self.cuda)
        self._all_short_until = min(self._all_short_until, free)
        self._look_again_at(free)
        self._ask_back_for_others()

    def _ask_back_for_others(self) -> None:
        """Ask turns back that others wait for, but for short ones: who waits for those is seen when they are so no
        more, by when most have ended.
        """
        cuda, now = self.cuda, monotonic()
        if now < self._all_short_until:
            return
        due = min((turn.free_at(cuda=cuda) for turn in self._running if not turn.asked_back), default=inf)
        self._all_short_until = due
        if due <= now:
            wanted = self._running.to_ask_back((*self._waiting, *self._paused))
            for turn in wanted:
                if turn.free_at(cuda=cuda) <= now:
                    self._ask_back(turn)
            due = min((turn.free_at(cuda=cuda) for turn in wanted if not turn.asked_back), default=inf)
        self._look_again_at(due)

    def _look_again_at(self, due: float) -> None:
        """See at that time [s], or before, which turns are to be asked back."""
        if due < self._asks_at:
            if self._asks_later is not None:
                self._asks_later.cancel()
            self._asks_at, self._asks_later = due, asyncio.get_running_loop().call_at(due, self._look_again)

    def _look_again(self) -> None:
        self._asks_at, self._asks_later = inf, None
        self._ask_back_for_others()

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
        self.busy_seconds += seconds
        self._running.end(turn)
        return seconds

    def _set_activity(self, activity: Activity) -> None:
        if activity == self._activity:
            return
        self._activity = activity
        for listener in tuple(self.listeners):
            listener()

"""The web process's side of rendering: keeps a worker running and gives it jobs in turn, as many at once as it has
lanes.

More devices mean more engines, with one worker each (server.render.engine_pool). A worker that ends, sends what it
should not, or says nothing for too long is replaced. While nobody wants anything, one pixel of what was rendered last
is rendered every few seconds, to see whether it still can be.
"""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable, Sequence

from gpu.errors import UserError
from server.render.activity import RECOVERING, Activity, EngineState
from server.render.cost import Speeds
from server.render.jobs_under_way import JobsUnderWay, Make, Turn
from server.render.pending import ERRORS, Answer
from server.render.quarantine import Quarantine
from server.render.schedule import Urgency
from server.render.standing import Standing
from server.render.watch import Watch
from server.render.worker_link import WorkerLink, WorkerLostError
from server.render.worker_process import WORKER
from server.render.workers import Workers
from server.wire.worker import (
    START_UP,
    STILLS,
    Cause,
    CloseScene,
    Failed,
    FromWorker,
    Job,
    Leave,
    Opened,
    OpenScene,
    Progress,
    Ready,
    SceneRef,
    Start,
)

# Before a new worker is started, by how many have ended since one was ready; one that was ready is replaced at once.
BACKOFF_SECONDS = (0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0)
MOST_STARTS = 5  # of workers in a row before one has ever been ready: what stops them does not go away
log = logging.getLogger("lumenwalk.engine")


class Engine(Standing):
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
        super().__init__()
        self.workers = Workers(command, start)
        self._jobs = JobsUnderWay(self, start.scene, hang_seconds, quarantine or Quarantine(), speeds or Speeds())
        self._link: WorkerLink | None = None
        self._watch: Watch | None = None
        self._was_ready = False  # a worker was, since the service began
        self._failures = 0  # workers that ended since one was ready

    @property
    def overdue(self) -> str:
        """What keeps the worker from others for too long, in words, if anything does."""
        return self._watch.overdue if self._watch else ""

    @property
    def waiting(self) -> Counter[Urgency]:
        """How many jobs wait for a turn, by urgency."""
        return self._jobs.waiting

    @property
    def max_scenes(self) -> int:
        """That the worker keeps at the same time."""
        return self.workers.start.max_scenes

    def queued(self, client: int) -> int:
        """How many jobs of a client wait or run."""
        return self._jobs.queued(client)

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
                    self.set_activity(Activity(EngineState.FAILED, str(error)))
                    return
                log.error("the worker cannot start again: %s", error)
            except WorkerLostError as error:
                log.error("%s", error)
                if not self._was_ready and self._failures + 1 >= MOST_STARTS:
                    text = f"the renderer could not be started, {MOST_STARTS} times; the last: {error}"
                    self.set_activity(Activity(EngineState.FAILED, text))
                    return
            except Exception:
                log.exception("the worker is started again after a fault in the web process")
            pause = BACKOFF_SECONDS[min(self._failures, len(BACKOFF_SECONDS) - 1)]
            self._failures += 1
            self.restarts += 1
            self.set_activity(RECOVERING)
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
        self._jobs.submit(client, urgency, make, turn, elsewhere)
        return turn

    def turn_away(self) -> None:
        """Another engine is ready, and this one is not: who waits for a turn is to go there."""
        self._jobs.turn_away()

    async def open(self, scene: SceneRef, packed: str = "") -> Opened:
        """Load a scene, `packed` if it was read already, and say what is in it; errors as the futures of `submit`."""
        answer = await self._answer_to(OpenScene(scene, packed=packed))
        assert isinstance(answer, Opened)
        return answer

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
        self._watch = watch = Watch(link, self._jobs)
        watching = asyncio.create_task(watch.keep(), name="watch")
        try:
            while True:
                message, payload = await link.receive(lambda: self._jobs.most_bytes)
                watch.heard()
                self._handle(link, message, payload)
        finally:
            watching.cancel()
            self._link = self._watch = None
            await self._jobs.settle(link, hung=watch.hung)

    def _handle(self, link: WorkerLink, message: FromWorker, payload: bytes) -> None:
        match message:
            case Progress(text, fraction):
                self.set_activity(Activity(self.activity.state, text, fraction))
            case Ready(device) if not self._jobs.taken:
                self.device = device
                self.holds(message.holdings)
                self._failures, self._was_ready = 0, True
                self._jobs.take(link, message.lanes)
            case Failed(request, text, cause) if request == START_UP and not self._jobs.taken:
                if cause is Cause.PROGRAM:
                    raise WorkerLostError(f"worker {link.pid} could not start")
                raise ERRORS[cause](text)
            case _:
                self._jobs.hear(link, message, payload)

"""The engines of a service, one worker each, and whose frames are rendered by which.

A client's frames stay on one engine, since what its walk leaves behind is there. It goes to another one
(server.render.placement) when its own has lost its worker, or when it walks and its own is far more crowded.
"""

import asyncio
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from time import monotonic

from server.render.activity import Activity, EngineState
from server.render.busy_meter import BusyMeter
from server.render.cost import Speeds
from server.render.engine import Engine
from server.render.jobs_under_way import Make, Turn
from server.render.pending import Reply
from server.render.placement import Candidate, choose, still_loading
from server.render.quarantine import Quarantine
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.render.worker_process import WORKER, WorkerProcess
from server.wire.worker import STILLS, Export, Pick, Render, SceneRef, Start

LATELY_SECONDS = 10.0  # after its last wish, a client no longer counts where engines are compared
WEIGH_SECONDS = 1.0  # between two looks at whether a walker's engine is more crowded than others
_BEST_FIRST = (EngineState.READY, EngineState.RECOVERING, EngineState.STARTING, EngineState.FAILED)


@dataclass
class _Client:
    """Where a client is, for which scene; when it last wanted a turn, and was last compared [s]."""

    engine: Engine
    scene: SceneRef
    wanted: float
    weighed: float


class EnginePool:
    """One engine or several; `engines` are in the order of the devices that were asked for."""

    def __init__(
        self, engines: Sequence[Engine], speeds: Speeds | None = None, now: Callable[[], float] = monotonic
    ) -> None:
        """speeds: what the engines have learnt of what pictures cost."""
        self.engines = tuple(engines)
        self.speeds = speeds or Speeds()
        self.listeners: set[Callable[[], None]] = set()
        self.fits: Callable[[Engine, SceneRef], bool] = lambda _engine, _scene: True  # whether one more scene does
        self._now = now
        self._clients: dict[int, _Client] = {}
        self._loading: dict[Engine, dict[SceneRef, float]] = {engine: {} for engine in self.engines}  # since when [s]
        self._meters = {engine: BusyMeter(now) for engine in self.engines}
        for engine in self.engines:
            engine.listeners.add(self._heard)

    @classmethod
    def of(
        cls, start: Start, devices: Sequence[str | None], command: Sequence[str] = WORKER, hang_seconds: float = 120.0
    ) -> "EnginePool":
        """An engine a device, that all know what ended a worker; parameters as of `Engine`."""
        quarantine, speeds = Quarantine(), Speeds()
        starts = [replace(start, device=device) for device in devices]
        return cls([Engine(it, command, hang_seconds, quarantine, speeds) for it in starts], speeds)

    # --- what they are doing, together ---

    @property
    def activity(self) -> Activity:
        """That of the engine that is best off, and has most to say; of one whose device cannot be used, if any."""
        unusable = [engine.activity for engine in self.engines if engine.unusable]
        activities = unusable or [engine.activity for engine in self.engines]
        return min(activities, key=lambda it: (_BEST_FIRST.index(it.state), not it.text))

    @property
    def ready(self) -> bool:
        """Whether one takes jobs now, and no device is unusable."""
        return self.activity.state is EngineState.READY

    @property
    def cuda(self) -> bool:
        """Whether one has a GPU, as far as is known."""
        return any(engine.cuda for engine in self.engines)

    @property
    def overdue(self) -> str:
        """What keeps all engines that are ready from others for too long, in words."""
        words = [engine.overdue for engine in self.engines if engine.ready]
        return words[0] if words and all(words) else ""

    @property
    def waiting(self) -> Counter[Urgency]:
        """How many jobs wait for a turn, by urgency."""
        return sum((engine.waiting for engine in self.engines), Counter())

    @property
    def restarts(self) -> int:
        """Of all workers."""
        return sum(engine.restarts for engine in self.engines)

    @property
    def device(self) -> str:
        """Those that render now, each once."""
        return ", ".join(dict.fromkeys(engine.device for engine in self.engines if engine.ready))

    @property
    def busy_seconds(self) -> float:
        """Device time of all."""
        return sum(engine.busy_seconds for engine in self.engines)

    @property
    def memory(self) -> tuple[int, int]:
        """Of all devices, used and all [bytes]; an engine that is not ready adds nothing."""
        return sum(engine.memory[0] for engine in self.engines), sum(engine.memory[1] for engine in self.engines)

    @property
    def scenes(self) -> tuple[SceneRef, ...]:
        """On any device."""
        return tuple(dict.fromkeys(scene for engine in self.engines for scene in engine.scenes))

    def activity_of(self, client: int) -> Activity:
        """What a client waits for: its own engine, unless it will go to another one."""
        known = self._clients.get(client)
        return known.engine.activity if known and (known.engine.ready or not self.ready) else self.activity

    def clients_of(self, engine: Engine) -> set[int]:
        """The numbers of those whose frames an engine renders."""
        return {client for client, known in self._clients.items() if known.engine is engine}

    # --- what is asked of them ---

    @contextmanager
    def early(self, first: WorkerProcess | None = None) -> Iterator[None]:
        """Have all first workers run from now on, for `run`; at the end of the context they end.

        first: that of the first engine, if it runs already.
        """
        with ExitStack() as workers:
            for number, engine in enumerate(self.engines):
                workers.enter_context(engine.workers.early(None if number else first))
            yield

    async def run(self) -> None:
        """Keep all workers running until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            for engine in self.engines:
                tasks.create_task(engine.run())

    def place(self, client: int, scene: SceneRef, urgency: Urgency) -> Engine:
        """The engine that renders a scene for a client; STILLS are rendered by any, each time anew."""
        now, known = self._now(), self._clients.get(client)
        stays = known is not None and known.scene == scene
        walks = urgency is Urgency.MOVING
        if known and stays and known.engine.ready and not (walks and now - known.weighed >= WEIGH_SECONDS):
            known.wanted = now
            return known.engine
        own = self.engines.index(known.engine) if known and stays else None
        engine = self.engines[choose(self._candidates(client, scene), own, walks=walks)]
        if scene not in engine.scenes and self._has_room(engine, client, scene):
            self._loading[engine].setdefault(scene, now)
        if client != STILLS:
            if known and known.engine is not engine:
                known.engine.leave(client)
            self._clients[client] = _Client(engine, scene, now, now)
        return engine

    def submit(self, client: int, scene: SceneRef, urgency: Urgency, make: Make) -> Turn:
        """As `Engine.submit`, by the engine that renders `scene` for the client when its turn comes."""
        turn: Turn = asyncio.get_running_loop().create_future()

        def ask() -> None:
            self.place(client, scene, urgency).submit(client, urgency, make, turn, ask)

        ask()
        return turn

    async def ask(
        self, client: int, job: Render | Pick | Export, urgency: Urgency, seconds: float | None = None
    ) -> Reply:
        """The answer to a job, which is sent in the client's turn. Raises what the futures of `Engine.submit` do;
        WorkerLostError also when no turn comes within so many seconds.
        """
        try:
            async with asyncio.timeout(seconds):
                reply = await self.submit(client, job.scene, urgency, lambda: job)
        except TimeoutError:
            raise WorkerLostError(f"no turn within {seconds:g} s; try again later") from None
        assert reply is not None  # there was a job
        return await reply

    def leave(self, client: int) -> None:
        """Free what is kept for a client."""
        self._clients.pop(client, None)
        for engine in self.engines:
            engine.leave(client)

    def _candidates(self, client: int, scene: SceneRef) -> list[Candidate]:
        now = self._now()
        lately = now - LATELY_SECONDS
        crowds = Counter(it.engine for key, it in self._clients.items() if key != client and it.wanted > lately)
        self._loading = {engine: still_loading(sent, engine.scenes, now) for engine, sent in self._loading.items()}
        return [
            Candidate(
                engine.activity.state,
                scene in engine.scenes or scene in self._loading[engine],
                self._has_room(engine, client, scene),
                bool(self._loading[engine]),
                crowds[engine] + engine.queued(STILLS),
                self._meters[engine].share(engine.busy_seconds),
            )
            for engine in self.engines
        ]

    def _has_room(self, engine: Engine, client: int, scene: SceneRef) -> bool:
        viewed = {it.scene for key, it in self._clients.items() if it.engine is engine and key != client} - {scene}
        return len(viewed) < engine.max_scenes and self.fits(engine, scene)

    def _heard(self) -> None:
        """An engine does something else now: who waits for one that cannot render goes to one that can."""
        for engine in self.engines:
            if not engine.ready:
                self._loading[engine].clear()  # it begins anew, with nothing
        if self.ready:
            for engine in self.engines:
                if not engine.ready:
                    engine.turn_away()
        for listener in tuple(self.listeners):
            listener()

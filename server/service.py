"""What the endpoints share: settings, scenes, the engines, and who is there."""

import asyncio
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field
from secrets import token_hex
from typing import Annotated, Protocol

from fastapi import Depends
from starlette.requests import HTTPConnection

from gpu.scene.edits import SceneEdits
from server.addresses import is_loopback
from server.jobs import ENDED, Jobs
from server.metrics import Metrics
from server.places import Places, asker
from server.rate_limit import Buckets
from server.refusals import ForbiddenError, TooBusyError
from server.render.engine_pool import EnginePool
from server.replicas import Replicas
from server.scenes.catalogue import Catalogue
from server.scenes.changed_files import ChangedFiles
from server.scenes.checker import Checker
from server.scenes.residency import Residency
from server.scenes.scene_edits import EditedScenes
from server.scenes.uploads import MAX_AT_ONCE
from server.settings import ServerSettings
from server.wire.worker import Opened, Render, SceneRef

# A page has one for a job that it watches; behind a proxy that nobody named, all pages are one client.
MAX_STREAMS, MAX_STREAMS_OF_ONE = 256, 64
WAITING_OF_ALL = 2  # times as many stills of all clients as of one may wait
OTHERS_VIEWERS = 8  # one place of so many for viewers is not for a client that has all others
MAX_EXPORTS = 2  # at once, of up to a quarter of a gigabyte each
# Edits of a client a second, and at once: a slider that is dragged is told thirty times a second.
EDIT_RATE, EDIT_BURST = 40.0, 80.0
# Picks of a client: a click each.
PICK_RATE, PICK_BURST = 10.0, 40.0

# What a client's requests and messages may let others wait for in the web process, in ms of a core: seconds, at once.
EFFORT_RATE, EFFORT_BURST = 500.0, 5000.0


class Assigner(Protocol):
    """Knows the replicas that viewers can be sent to."""

    async def choose(self, scene: str) -> str:
        """The path prefix of one for a viewer of a scene; errors as `Replicas.choose`."""


@dataclass
class Service:
    """One running service."""

    settings: ServerSettings
    catalogue: Catalogue
    engines: EnginePool
    checker: Checker
    run: str = field(default_factory=lambda: token_hex(8))  # tells it from one that is started after it
    viewers: dict[int, str] = field(default_factory=dict)  # and their clients
    greeting: list[asyncio.Timeout] = field(default_factory=list)  # who has not said hello yet, the oldest first
    last_viewer: int = 0
    viewing: dict[int, SceneRef] = field(default_factory=dict)  # what viewers look at
    stills: Places = field(init=False)
    streams: Places = field(default_factory=lambda: Places("event streams", MAX_STREAMS, MAX_STREAMS_OF_ONE))
    exporting: Places = field(default_factory=lambda: Places("exports", MAX_EXPORTS, 1))
    uploading: Places = field(default_factory=lambda: Places("uploads", MAX_AT_ONCE, MAX_AT_ONCE // 2))
    metrics: Metrics = field(default_factory=Metrics)
    edited: EditedScenes = field(init=False)
    changed_files: ChangedFiles = field(init=False)
    edit_rates: Buckets = field(default_factory=lambda: Buckets(EDIT_RATE, EDIT_BURST))
    pick_rates: Buckets = field(default_factory=lambda: Buckets(PICK_RATE, PICK_BURST))
    efforts: Buckets = field(default_factory=lambda: Buckets(EFFORT_RATE, EFFORT_BURST))
    stopping: asyncio.Event = field(default_factory=asyncio.Event)  # set once: the service ends

    def __post_init__(self) -> None:
        limits = self.settings
        token = limits.token.get_secret_value() if limits.token else None
        self.replicas: Assigner | None = Replicas(limits.replicas, token) if limits.replicas else None
        self.edited = EditedScenes(limits.max_own_edits)
        self.residency = Residency(
            self.engines,
            self.checker,
            limits.reserve_bytes,
            self.used,
            self.catalogue.touch,
            self._learn,
        )
        self.changed_files = ChangedFiles(self.viewing.values, self.catalogue.versions, self.residency.inspect)
        waiting = limits.max_waiting_renders
        self.stills = Places("renders that wait", WAITING_OF_ALL * waiting, waiting)
        self.jobs = Jobs(
            self.engines,
            self.residency,
            self.dismiss,
            max_jobs=limits.max_jobs,
            keep_seconds=limits.job_result_seconds,
            keep_bytes=limits.job_results_bytes,
        )

    def _learn(self, scene: SceneRef, opened: Opened) -> None:
        self.edited.learn(scene, opened.info)
        self.catalogue.versions.learn(scene, opened.beside)

    def check_cost(self, job: Render, frames: int, pictures: int = 1) -> None:
        """TooLongError, with what would do, where pictures are expected to take the device for too long."""
        most, cuda = self.settings.max_render_seconds, self.engines.cuda
        self.engines.speeds.check(job, frames, most, cuda=cuda, pictures=pictures)

    def check_edits(self, client: Hashable) -> None:
        """ForbiddenError where this service takes no edits; TooBusyError where a client or viewer sends too many."""
        if not self.settings.edits:
            raise ForbiddenError("this server takes no edits of its scenes")
        if self.edit_rates.empty(client):
            raise TooBusyError(f"more than {EDIT_RATE:.0f} edits a second came from you; send fewer")
        self.edit_rates.take(client)

    async def edits_of(self, scene: SceneRef, own: SceneEdits | None) -> SceneEdits:
        """What a client has pictures of: its `own` edits, which ForbiddenError refuses here, or those of all, for which
        a scene is loaded where it is not known whether they fit; errors as of `Residency.open`.
        """
        if own is None:
            if self.edited.unproven(scene):
                await self.residency.open(scene)
            return self.edited.of(scene)
        if not self.settings.edits:
            raise ForbiddenError("this server takes no edits of its scenes")
        return own

    def check_picks(self, client: Hashable) -> None:
        """TooBusyError where a client picks too often."""
        if self.pick_rates.empty(client):
            raise TooBusyError(f"more than {PICK_RATE:.0f} picks a second came from you; send fewer")
        self.pick_rates.take(client)

    def number(self) -> int:
        """A viewer number that was never used before; `dismiss` frees what the worker keeps for it."""
        self.last_viewer += 1
        return self.last_viewer

    @property
    def full(self) -> bool:
        """Whether as many viewers are here as may be, or as many of the client that asks."""
        client, most = asker.get(), self.settings.max_viewers
        # Who speaks for this machine may speak for many, as a proxy does that nobody has named.
        mine = most if is_loopback(client) else most - most // OTHERS_VIEWERS
        return len(self.viewers) >= most or sum(it == client for it in self.viewers.values()) >= mine

    def admit(self) -> int | None:
        """A number for one more viewer of who asks, never used before; None where there is no place."""
        if self.full:
            return None
        viewer = self.number()
        self.viewers[viewer] = asker.get()
        return viewer

    def dismiss(self, viewer: int) -> None:
        """A viewer has left."""
        self.viewers.pop(viewer, None)
        self.viewing.pop(viewer, None)
        self.engines.leave(viewer)

    def stop(self) -> None:
        """The service ends: whoever waits is told."""
        self.stopping.set()
        self.jobs.stop()

    def used(self) -> Iterator[SceneRef]:
        """The scenes that somebody looks at, or that a job is to render."""
        yield from self.viewing.values()
        yield from (job.render.scene for job in self.jobs.all if job.state not in ENDED)

    def in_use(self, scene_id: str) -> bool:
        """Whether somebody looks at a scene or loads it, or a job is to render it."""
        return self.residency.opening(scene_id) or any(scene.id == scene_id for scene in self.used())


async def _service(connection: HTTPConnection) -> Service:  # else FastAPI asks a thread, and every answer waits for it
    service = connection.app.state.service
    assert isinstance(service, Service)
    return service


TheService = Annotated[Service, Depends(_service)]

"""An engine without a worker, for tests of what uses it."""

import asyncio
from collections.abc import Callable

from gpu.settings import RenderSettings
from server.render.engine import Engine
from server.render.jobs_under_way import Make, Turn
from server.render.pending import Reply
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.wire.browser import Bounds, SceneInfo
from server.wire.worker import Closed, CloseScene, Done, Job, Opened, OpenScene, Render, SceneCamera, SceneRef, Start

BOX = SceneRef("cornell-box", "cornell-box")


def order(viewer: int = 7, scene: SceneRef = BOX) -> Render:
    """A small picture."""
    return Render(viewer, scene, SceneCamera(0), (8, 4), RenderSettings(), ".png")


class FakeEngine(Engine):
    """Renders at once, in memory: averages as a worker does, and loses what it has at the orders in `deaths`.

    Counts orders from 1; an order waits for `gate`, when there is one.
    """

    def __init__(
        self,
        deaths: tuple[int, ...] = (),
        failure: Exception | None = None,
        lost: type[WorkerLostError] = WorkerLostError,
    ) -> None:
        super().__init__(Start(BOX))
        self.orders: list[tuple[int, Urgency, Job]] = []
        self.left: list[int] = []
        self.opened: list[SceneRef] = []
        self.gate: asyncio.Event | None = None
        self._deaths = deaths
        self._failure = failure
        self._lost = lost
        self._samples: dict[int, int] = {}

    def submit(
        self,
        client: int,
        urgency: Urgency,
        make: Make,
        turn: Turn | None = None,
        elsewhere: Callable[[], None] | None = None,
    ) -> Turn:
        turn = turn or asyncio.get_running_loop().create_future()
        given = asyncio.ensure_future(self._give(client, urgency, make))
        turn.add_done_callback(lambda _: given.cancel())
        given.add_done_callback(lambda _: turn.done() or turn.set_result(given.result()))
        return turn

    async def _give(self, client: int, urgency: Urgency, make: Make) -> asyncio.Future[Reply]:
        if self.gate is not None:
            await self.gate.wait()
        job = make()
        assert job is not None
        self.orders.append((client, urgency, job))
        reply: asyncio.Future[Reply] = asyncio.get_running_loop().create_future()
        if len(self.orders) in self._deaths:
            self._samples = {}
            reply.set_exception(self._lost("the renderer was lost"))
        elif self._failure is not None:
            reply.set_exception(self._failure)
        elif isinstance(job, Render):
            image = {"none": b"", "rgb": bytes(3 * job.size[0] * job.size[1])}.get(job.output, b"image")
            reply.set_result((self._done(job), image))
        elif isinstance(job, OpenScene):
            self.opened.append(job.scene)
            self.scenes = (*self.scenes, job.scene)
            bounds = Bounds(min=(0.0, 0.0, 0.0), max=(1.0, 1.0, 1.0))
            info = SceneInfo(id=job.scene.id, name="", cameras=(), bounds=bounds, triangles=1)
            reply.set_result((Opened(1, info), b""))
        elif isinstance(job, CloseScene):
            self.scenes = tuple(scene for scene in self.scenes if scene != job.scene)
            reply.set_result((Closed(1), b""))
        await asyncio.sleep(0)
        return reply

    def leave(self, viewer: int) -> None:
        self.left.append(viewer)

    def _done(self, job: Render) -> Done:
        before = self._samples.get(job.viewer, 0)
        samples = 1 if not job.sample or job.sample != before else before + 1
        self._samples[job.viewer] = samples
        return Done(1, job.size, 2.0, 0.5, samples, 1, {"shade": 1.0}, {}, {})

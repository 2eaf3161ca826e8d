"""An engine with a worker that draws gradients, for tests of both."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress

from harness import GRADIENT_WORKER, PATIENCE

from gpu.settings import RenderSettings
from server.render.engine import Engine
from server.render.schedule import Urgency
from server.wire.worker import Done, Render, SceneCamera, SceneRef, Start

SCENE = SceneRef("cornell-box", "cornell-box")


def job(viewer: int = 0, seed: int = 0) -> Render:
    return Render(viewer, SCENE, SceneCamera(0), (8, 8), RenderSettings(seed=seed), "jpeg")


@asynccontextmanager
async def running(
    device: str | None = None, command: tuple[str, ...] = GRADIENT_WORKER, hang_seconds: float = 20.0
) -> AsyncIterator[Engine]:
    engine = Engine(Start(SCENE, device), command, hang_seconds)
    task = asyncio.create_task(engine.run())
    try:
        yield engine
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE):
        while not condition():
            await asyncio.sleep(0.01)


async def result(engine: Engine, render: Render) -> Done:
    reply = await engine.submit(render.viewer, Urgency.MOVING, lambda: render)
    assert reply is not None
    done, _ = await reply
    assert isinstance(done, Done)
    return done


def check(scenario: Callable[[Engine], Awaitable[None]]) -> None:
    """Runs a scenario with a ready engine."""

    async def main() -> None:
        async with running() as engine:
            await until(lambda: engine.ready)
            await scenario(engine)

    asyncio.run(main())

"""Several jobs at once, in the engine and a worker."""

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable

import pytest
from gradient_worker import GATHER_SEED
from live_engine import job, result, running, until

from server.render.engine import Engine
from server.render.quarantine import QuarantinedError
from server.render.schedule import Urgency
from server.render.worker_link import InnocentLossError
from server.wire.worker import Render

LANES = 3


def with_lanes(scenario: Callable[[Engine], Awaitable[None]]) -> None:
    async def main() -> None:
        async with running(device=f"lanes {LANES}") as engine:
            await until(lambda: engine.ready)
            await scenario(engine)

    asyncio.run(main())


def test_as_many_jobs_are_under_way_as_the_worker_has_lanes_and_poses_are_taken_late() -> None:
    """None of the first would end alone."""

    async def scenario(engine: Engine) -> None:
        made: list[int] = []

        def make(viewer: int) -> Render:
            made.append(viewer)
            return job(viewer, seed=GATHER_SEED)

        async def submit(viewer: int) -> None:
            reply = await engine.submit(viewer, Urgency.MOVING, lambda: make(viewer))
            assert reply is not None
            await reply

        waiting = [asyncio.ensure_future(submit(viewer)) for viewer in (1, 1, 2)]
        await until(lambda: len(made) == 2)
        assert (made, engine.queued(1), engine.waiting[Urgency.MOVING]) == ([1, 2], 2, 1)  # one at a time for each
        waiting += [asyncio.ensure_future(submit(viewer)) for viewer in (3, 4)]
        await asyncio.gather(*waiting)
        assert sorted(made) == [1, 1, 2, 3, 4]
        assert made[:3] == [1, 2, 3]
        await until(lambda: engine.queued(1) == 0)  # a picture may come before the word that its lane is free

    with_lanes(scenario)


def test_a_crash_with_several_jobs_under_way_is_held_against_what_is_there_again() -> None:
    async def scenario(engine: Engine) -> None:
        for number in (1, 2):
            replies = [
                await engine.submit(viewer, Urgency.MOVING, lambda: job(2, seed=GATHER_SEED)) for viewer in (1, 2)
            ]
            assert engine.worker_pid is not None
            os.kill(engine.worker_pid, signal.SIGKILL)
            for reply in replies:
                assert reply is not None
                with pytest.raises(InnocentLossError):
                    await reply
            await result(engine, job())
            assert engine.restarts == number
        with pytest.raises(QuarantinedError):
            await result(engine, job(seed=GATHER_SEED))

    with_lanes(scenario)

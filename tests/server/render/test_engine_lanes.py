"""Several jobs at once, in the engine and a worker."""

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable
from dataclasses import replace

import pytest
from gradient_worker import ENOUGH, FAULT_SEED, GATHER_SEED, HANG_SEED, SLICED_SEED
from live_engine import job, result, running, until

from server.render.engine import Engine
from server.render.quarantine import QuarantinedError
from server.render.schedule import Urgency
from server.render.worker_link import InnocentLossError, WorkerLostError
from server.wire.worker import Render

LANES = 3


def with_lanes(scenario: Callable[[Engine], Awaitable[None]], hang_seconds: float = 20.0) -> None:
    async def main() -> None:
        async with running(device=f"lanes {LANES}", hang_seconds=hang_seconds) as engine:
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


def test_of_several_jobs_under_way_the_one_that_ends_a_worker_is_out_and_no_other() -> None:
    innocent, culprit = job(1, seed=SLICED_SEED), job(2, seed=FAULT_SEED)

    async def scenario(engine: Engine) -> None:
        lost = await asyncio.gather(result(engine, innocent), result(engine, culprit), return_exceptions=True)
        assert [type(error) for error in lost] == [InnocentLossError] * 2
        # Now each has a worker to itself.
        with pytest.raises(WorkerLostError) as found:
            await result(engine, culprit)
        assert type(found.value) is WorkerLostError
        with pytest.raises(QuarantinedError):
            await result(engine, replace(culprit, viewer=3))
        await with_enough_others(engine, innocent)
        assert engine.restarts == 2

    with_lanes(scenario)


def test_nobody_is_out_for_workers_that_somebody_kills() -> None:
    innocent = job(1, seed=SLICED_SEED)

    async def scenario(engine: Engine) -> None:
        for number in (1, 2, 3):
            both = [asyncio.ensure_future(result(engine, replace(innocent, viewer=viewer))) for viewer in (1, 2)]
            await until(lambda: engine.queued(1) + engine.queued(2) == 2 and not engine.waiting.total())
            assert engine.worker_pid is not None
            os.kill(engine.worker_pid, signal.SIGKILL)
            lost = await asyncio.gather(*both, return_exceptions=True)
            assert [type(error) for error in lost] == [InnocentLossError] * 2
            await with_enough_others(engine, innocent)
            assert engine.restarts == number

    with_lanes(scenario)


def test_what_hangs_for_longer_than_it_is_suspected_is_alone_until_it_is_blamed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("server.render.quarantine.SUSPECT_SECONDS", 0.3)
    culprit = job(1, seed=HANG_SEED)

    async def scenario(engine: Engine) -> None:
        both = (result(engine, one) for one in (culprit, job(2, seed=SLICED_SEED)))
        lost = await asyncio.gather(*both, return_exceptions=True)
        assert [type(error) for error in lost] == [InnocentLossError] * 2
        again, others = asyncio.ensure_future(result(engine, culprit)), []
        await until(lambda: [turn.entry.client for turn in engine._jobs.running] == [1])
        while not again.done():
            others.append(asyncio.ensure_future(result(engine, job(3 + len(others)))))
            await asyncio.sleep(0.1)
        assert type(again.exception()) is WorkerLostError
        await asyncio.gather(*others)
        with pytest.raises(QuarantinedError):
            await result(engine, culprit)
        assert engine.restarts == 2

    with_lanes(scenario, hang_seconds=1.5)


async def with_enough_others(engine: Engine, sliced: Render) -> None:
    """A job that is done once so many others are."""
    others = [result(engine, job(viewer)) for viewer in range(3, 3 + ENOUGH)]
    await asyncio.gather(result(engine, sliced), *others)

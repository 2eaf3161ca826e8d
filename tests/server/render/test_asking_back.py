"""Jobs that others interrupt, in the engine and a worker."""

import asyncio

import pytest
from gradient_worker import ENOUGH, FAULT_SEED, SLICED_SEED
from harness import PATIENCE
from live_engine import check, job, result, until

from server.render.engine import Engine
from server.render.schedule import Urgency
from server.render.worker_link import InnocentLossError, WorkerLostError


def test_others_have_turns_within_a_long_job() -> None:
    """The job ends once ENOUGH pictures of others were made within it, which else would wait for its end."""

    async def scenario(engine: Engine) -> None:
        reply = await engine.submit(1, Urgency.STILL, lambda: job(seed=SLICED_SEED))
        assert reply is not None
        for _ in range(ENOUGH):
            assert not reply.done()
            await result(engine, job(viewer=2))
        assert engine.waiting[Urgency.STILL] <= 1
        await reply
        await result(engine, job(viewer=2))

    check(scenario)


def test_timers_of_other_event_loops_serve_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """uvloop's do not tell when they are due."""

    class Timer:
        def __init__(self, handle: asyncio.Handle) -> None:
            self._handle = handle

        def __getattr__(self, name: str) -> object:
            if name == "when":
                raise AttributeError(name)
            return getattr(self._handle, name)

    async def scenario(engine: Engine) -> None:
        loop = asyncio.get_running_loop()
        call_at = loop.call_at
        monkeypatch.setattr(loop, "call_at", lambda *work, **kwargs: Timer(call_at(*work, **kwargs)))
        reply = await engine.submit(1, Urgency.STILL, lambda: job(seed=SLICED_SEED))
        assert reply is not None
        for _ in range(ENOUGH):
            await result(engine, job(viewer=2))
        await reply

    check(scenario)


def test_two_long_jobs_take_turns() -> None:
    async def scenario(engine: Engine) -> None:
        replies = [await engine.submit(n, Urgency.STILL, lambda: job(seed=SLICED_SEED)) for n in (1, 2)]
        for _ in range(ENOUGH):
            await result(engine, job(viewer=3))
        for reply in replies:
            assert reply is not None
            await reply

    check(scenario)


def test_a_long_job_that_nobody_wants_any_more_ends() -> None:
    async def scenario(engine: Engine) -> None:
        reply = await engine.submit(1, Urgency.STILL, lambda: job(seed=SLICED_SEED))
        assert reply is not None
        reply.cancel()
        await until(lambda: not engine._jobs._pending)
        assert await result(engine, job(viewer=2))

    check(scenario)


def test_a_worker_that_dies_owes_nothing_to_jobs_that_pause() -> None:
    async def scenario(engine: Engine) -> None:
        reply = await engine.submit(1, Urgency.STILL, lambda: job(seed=SLICED_SEED))
        with pytest.raises(WorkerLostError):
            await result(engine, job(viewer=2, seed=FAULT_SEED))
        assert reply is not None
        with pytest.raises(InnocentLossError):
            await reply
        await result(engine, job(viewer=2))

    check(scenario)


def test_frames_of_one_viewer_come_in_their_order() -> None:
    async def scenario(engine: Engine) -> None:
        first = await engine.submit(1, Urgency.MOVING, lambda: job(1, SLICED_SEED))
        assert first is not None
        second = asyncio.create_task(result(engine, job(1)))
        for _ in range(ENOUGH):
            assert not second.done()
            await result(engine, job(2))
        await first
        await second

    check(scenario)


@pytest.mark.parametrize(("urgency", "interrupted"), [(Urgency.MOVING, False), (Urgency.REFINING, True)])
def test_those_who_move_leave_each_other_whole_frames(
    urgency: Urgency, interrupted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frames that all share would all come late; what is less urgent gives way at once."""
    monkeypatch.setattr("server.render.running.WHOLE_FRAME_SECONDS", PATIENCE)
    monkeypatch.setattr("server.render.watch.LONG_TURN_SECONDS", PATIENCE)

    async def scenario(engine: Engine) -> None:
        reply = await engine.submit(1, urgency, lambda: job(1, SLICED_SEED))
        assert reply is not None
        other = asyncio.create_task(result(engine, job(2)))
        await asyncio.wait([other], timeout=PATIENCE if interrupted else 0.3)
        assert other.done() == interrupted
        reply.cancel()
        await other

    check(scenario)

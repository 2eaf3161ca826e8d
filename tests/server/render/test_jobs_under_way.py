import asyncio
from contextlib import suppress

import pytest
from gradient_worker import BUG_SEED, FAULT_SEED, MEMORY_SEED, SLICED_SEED, SLOW_SECONDS, SLOW_SEED, WRONG_SEED
from live_engine import check, job, result, until

from gpu.errors import OutOfMemoryError, UserError
from server.render.engine import Engine
from server.render.pending import RenderFaultError
from server.render.quarantine import QuarantinedError
from server.render.schedule import QueueEntry, Urgency
from server.render.worker_link import InnocentLossError, WorkerLostError
from server.wire.worker import Render


def test_a_job_is_made_when_its_turn_comes() -> None:
    async def scenario(engine: Engine) -> None:
        newest = 1
        slow = await engine.submit(1, Urgency.MOVING, lambda: job(seed=SLOW_SEED))
        assert slow is not None
        waiting = engine.submit(2, Urgency.MOVING, lambda: job(seed=newest))
        assert engine.waiting[Urgency.MOVING] == 1
        newest = WRONG_SEED
        reply = await waiting
        assert reply is not None
        with pytest.raises(UserError):
            await reply

    check(scenario)


def test_whoever_wants_nothing_any_more_gives_the_turn_away() -> None:
    async def scenario(engine: Engine) -> None:
        assert await engine.submit(1, Urgency.MOVING, lambda: None) is None
        await result(engine, job())

    check(scenario)


def test_whoever_hears_of_a_failure_can_still_give_the_next_turn_away() -> None:
    async def scenario(engine: Engine) -> None:
        failed = False
        reply = await engine.submit(1, Urgency.MOVING, lambda: job(seed=WRONG_SEED))
        assert reply is not None
        waiting = engine.submit(1, Urgency.MOVING, lambda: None if failed else job())
        try:
            await reply
        except UserError:
            failed = True
        assert await waiting is None

    check(scenario)


def test_whoever_costs_less_has_more_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario(engine: Engine) -> None:
        served: list[int] = []

        def make(viewer: int, seed: int) -> Render:
            served.append(viewer)
            return job(viewer, seed)

        async def viewer(number: int, seed: int) -> None:
            for _ in range(3):
                await engine.submit(number, Urgency.MOVING, lambda: make(number, seed))

        def charged(entry: QueueEntry, seconds: float) -> None:
            charge(entry, min(seconds, SLOW_SECONDS / 4) if entry.client == 2 else seconds)  # on a busy machine, too

        charge = engine._jobs._schedule.charge
        monkeypatch.setattr(engine._jobs._schedule, "charge", charged)
        await asyncio.gather(viewer(1, SLOW_SEED), viewer(2, 0))
        assert served == [1, 2, 2, 2, 1, 1]

    check(scenario)


def test_one_who_leaves_while_waiting_takes_no_turn() -> None:
    async def scenario(engine: Engine) -> None:
        await engine.submit(1, Urgency.MOVING, lambda: job(seed=SLOW_SEED))
        leaver = engine.submit(1, Urgency.MOVING, lambda: pytest.fail("it has left"))
        assert engine.waiting[Urgency.MOVING] == 1
        leaver.cancel()
        await result(engine, job())

    check(scenario)


def test_errors_are_the_users_or_the_programs() -> None:
    async def scenario(engine: Engine) -> None:
        with pytest.raises(UserError, match="wrong one"):
            await result(engine, job(seed=WRONG_SEED))
        with pytest.raises(RenderFaultError, match="internal error"):
            await result(engine, job(seed=BUG_SEED))
        await result(engine, job())
        assert engine.restarts == 0

    check(scenario)


def test_an_error_of_whoever_makes_a_job_is_his_own() -> None:
    def broken() -> Render:
        raise ValueError("a bug")

    async def scenario(engine: Engine) -> None:
        with pytest.raises(ValueError, match="a bug"):
            await engine.submit(1, Urgency.MOVING, broken)
        await result(engine, job())
        assert engine.restarts == 0

    check(scenario)


def test_too_little_memory_is_told_as_such() -> None:
    async def scenario(engine: Engine) -> None:
        with pytest.raises(OutOfMemoryError, match="ask for less"):
            await result(engine, job(seed=MEMORY_SEED))
        await result(engine, job())
        assert engine.restarts == 0

    check(scenario)


def test_what_crashed_a_worker_is_refused_to_all_and_others_are_innocent() -> None:
    async def scenario(engine: Engine) -> None:
        encoding = await engine.submit(1, Urgency.MOVING, lambda: job(1))
        waiting = asyncio.ensure_future(result(engine, job(3)))
        with pytest.raises(WorkerLostError) as lost:
            await result(engine, job(2, seed=FAULT_SEED))
        assert not isinstance(lost.value, InnocentLossError)
        assert encoding is not None
        with suppress(InnocentLossError):  # it may have been answered in time
            await encoding
        with pytest.raises(QuarantinedError, match="nobody has it tried again"):
            await result(engine, job(4, seed=FAULT_SEED))
        await waiting
        await result(engine, job(4))
        assert engine.restarts == 1

    check(scenario)


@pytest.mark.parametrize(("seed", "acquitted"), [(WRONG_SEED, True), (MEMORY_SEED, True), (BUG_SEED, False)])
def test_a_suspect_that_fails_by_an_ordinary_mistake_is_acquitted(seed: int, acquitted: bool) -> None:
    async def scenario(engine: Engine) -> None:
        quarantine = engine._jobs._quarantine
        quarantine.suspect([job(seed=seed)])
        with suppress(UserError, RenderFaultError):
            await result(engine, job(seed=seed))
        assert quarantine.suspecting != acquitted

    check(scenario)


def test_a_suspect_that_nobody_wants_any_more_is_not_acquitted() -> None:
    async def scenario(engine: Engine) -> None:
        quarantine = engine._jobs._quarantine
        quarantine.suspect([job(seed=SLICED_SEED)])
        reply = await engine.submit(0, Urgency.STILL, lambda: job(seed=SLICED_SEED))
        assert reply is not None
        reply.cancel()
        await result(engine, job(1))
        await until(lambda: not engine._jobs._pending)
        assert quarantine.suspecting

    check(scenario)

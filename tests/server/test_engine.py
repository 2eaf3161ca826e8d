import asyncio
import os
import signal
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress

import pytest
from gradient_worker import BUG_SEED, FAULT_SEED, SLOW_SEED, WRONG_SEED
from harness import GRADIENT_WORKER

from gpu.errors import UserError
from gpu.settings import RenderSettings
from server.engine import Engine, EngineState, RenderFaultError
from server.link import WorkerLostError
from server.messages import Done, Render, SceneCamera, SceneRef, Start
from server.schedule import Urgency

SCENE = SceneRef("cornell-box", "cornell-box")


def job(viewer: int = 0, seed: int = 0) -> Render:
    return Render(viewer, SCENE, SceneCamera(0), (8, 8), RenderSettings(seed=seed), "jpeg")


@asynccontextmanager
async def running(device: str | None = None) -> AsyncIterator[Engine]:
    engine = Engine(Start(SCENE, device), GRADIENT_WORKER)
    task = asyncio.create_task(engine.run())
    try:
        yield engine
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(20):
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


def test_a_job_is_made_when_its_turn_comes() -> None:
    async def scenario(engine: Engine) -> None:
        newest = 1
        slow = await engine.submit(1, Urgency.MOVING, lambda: job(seed=SLOW_SEED))
        assert slow is not None
        waiting = asyncio.create_task(engine.submit(2, Urgency.MOVING, lambda: job(seed=newest)))
        await asyncio.sleep(0.05)
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


def test_turns_go_round() -> None:
    async def scenario(engine: Engine) -> None:
        served: list[int] = []

        def make(viewer: int) -> Render:
            served.append(viewer)
            return job(viewer)

        async def viewer(number: int) -> None:
            for _ in range(3):
                await engine.submit(number, Urgency.MOVING, lambda: make(number))

        await engine.submit(1, Urgency.MOVING, lambda: job(seed=SLOW_SEED))  # so that all of them wait
        await asyncio.gather(*(viewer(number) for number in (1, 2, 3)))
        assert served == [1, 2, 3] * 3

    check(scenario)


def test_one_who_leaves_while_waiting_takes_no_turn() -> None:
    async def scenario(engine: Engine) -> None:
        await engine.submit(1, Urgency.MOVING, lambda: job(seed=SLOW_SEED))
        leaver = asyncio.create_task(engine.submit(1, Urgency.MOVING, lambda: pytest.fail("it has left")))
        await asyncio.sleep(0.05)
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


def test_a_killed_worker_is_replaced_and_owes_nothing() -> None:
    async def scenario(engine: Engine) -> None:
        reply = await engine.submit(1, Urgency.MOVING, lambda: job(seed=SLOW_SEED))
        assert reply is not None
        first = engine.worker_pid
        assert first is not None
        os.kill(first, signal.SIGKILL)
        with pytest.raises(WorkerLostError):
            await reply
        await result(engine, job())
        assert engine.worker_pid != first
        assert engine.restarts == 1

    check(scenario)


def test_a_worker_whose_device_fails_is_replaced() -> None:
    async def scenario(engine: Engine) -> None:
        with pytest.raises(WorkerLostError):
            await result(engine, job(seed=FAULT_SEED))
        await result(engine, job())
        assert engine.restarts == 1

    check(scenario)


def test_the_first_start_that_fails_by_the_users_fault_is_final() -> None:
    async def main() -> None:
        async with running(device="none") as engine:
            await until(lambda: engine.activity.state is EngineState.FAILED)
            assert "no device 'none'" in engine.activity.text

    asyncio.run(main())


def test_listeners_hear_of_every_state() -> None:
    async def main() -> None:
        async with running() as engine:
            states: list[EngineState] = []
            engine.listeners.add(lambda: states.append(engine.activity.state))
            await until(lambda: engine.ready)
            pid = engine.worker_pid
            assert pid is not None
            os.kill(pid, signal.SIGKILL)
            await until(lambda: engine.restarts == 1 and engine.ready)
            assert list(dict.fromkeys(states)) == [EngineState.STARTING, EngineState.READY, EngineState.RECOVERING]
            assert states[-1] is EngineState.READY

    asyncio.run(main())


def test_no_worker_is_left_behind() -> None:
    async def main() -> int:
        async with running() as engine:
            await until(lambda: engine.ready)
            assert engine.worker_pid is not None
            return engine.worker_pid

    with pytest.raises(ProcessLookupError):
        os.kill(asyncio.run(main()), 0)


def test_a_command_that_does_not_exist_is_the_users_fault() -> None:
    async def main() -> None:
        engine = Engine(Start(SCENE), ("/nowhere/python",))
        await engine.run()
        assert engine.activity.state is EngineState.FAILED

    asyncio.run(main())

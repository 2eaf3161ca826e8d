import asyncio
import os
import signal

from gradient_worker import MEMORY, SLOW_SECONDS, SLOW_SEED
from live_engine import SCENE, check, job, result, running, until

from server.render.activity import EngineState
from server.render.engine import Engine
from server.wire.worker import SceneRef


def test_what_the_device_holds_is_known_as_soon_as_it_is_ready() -> None:
    async def main() -> None:
        async with running() as engine:
            known: list[tuple[tuple[SceneRef, ...], tuple[int, int]]] = []

            def heard() -> None:
                if engine.ready:
                    known.append((engine.scenes, engine.memory))

            engine.listeners.add(heard)
            await until(lambda: bool(known))
            assert known[0] == ((SCENE,), MEMORY)

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


def test_device_time_memory_and_scenes_are_counted() -> None:
    async def scenario(engine: Engine) -> None:
        before = engine.busy_seconds
        await result(engine, job(seed=SLOW_SEED))
        assert engine.busy_seconds >= before + SLOW_SECONDS
        assert engine.memory == MEMORY
        hall = SceneRef("hall", "hall")
        await engine.open(hall)
        assert engine.scenes == (SCENE, hall)
        await engine.close(hall)
        assert engine.scenes == (SCENE,)

    check(scenario)

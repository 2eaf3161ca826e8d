import asyncio
import os
import signal
from dataclasses import replace

import pytest
from gradient_worker import FAULT_SEED
from harness import PATIENCE, rogue
from live_engine import SCENE, check, job, result, running, until

from server.render.activity import EngineState
from server.render.engine import BACKOFF_SECONDS, MOST_STARTS, Engine
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.wire.worker import Start

KILLS = len(BACKOFF_SECONDS) + 1  # each of them would have to wait longer, were they failures to start


def test_a_killed_worker_is_replaced_and_owes_nothing() -> None:
    async def scenario(engine: Engine) -> None:
        await result(engine, job())  # the first heartbeat is over
        while engine._jobs.running:  # its picture may come before word that its turn is over
            await asyncio.sleep(0.001)
        first = engine.worker_pid
        assert first is not None
        os.kill(first, signal.SIGSTOP)  # so that it answers nothing before
        reply = await engine.submit(1, Urgency.MOVING, lambda: job())
        assert reply is not None
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


def test_what_the_worker_kept_for_a_viewer_goes_when_it_leaves() -> None:
    async def scenario(engine: Engine) -> None:
        async def averaged(viewer: int, sample: int) -> int:
            return (await result(engine, replace(job(viewer), sample=sample))).samples

        for viewer in (1, 2):
            assert [await averaged(viewer, sample) for sample in (0, 1)] == [1, 2]
        engine.leave(1)
        assert await averaged(1, 2) == 1
        assert await averaged(2, 2) == 3

    check(scenario)


def test_the_first_start_that_fails_by_the_users_fault_is_final() -> None:
    async def main() -> None:
        async with running(device="none") as engine:
            await until(lambda: engine.activity.state is EngineState.FAILED)
            assert "no device 'none'" in engine.activity.text

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


def waited_for(pid: int) -> bool:
    """Whether a child that ended was waited for, so that it is no zombie."""
    try:
        os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return True
    return False


def test_a_worker_killed_many_times_in_a_row_comes_back_each_time() -> None:
    async def scenario(engine: Engine) -> None:
        for _ in range(KILLS):
            pid = engine.worker_pid
            assert pid is not None
            pids.append(pid)
            os.kill(pid, signal.SIGKILL)
            await until(lambda: not engine.ready)
            async with asyncio.timeout(PATIENCE):
                await result(engine, job())
        assert engine.restarts == KILLS
        await until(lambda: not engine._jobs._pending and not engine._jobs._waiting)  # the first heartbeat is over
        assert len(os.listdir("/proc/self/fd")) <= files  # noqa: PTH208

    async def main() -> None:
        nonlocal files
        async with running() as engine:
            await until(lambda: engine.ready)
            files = len(os.listdir("/proc/self/fd"))  # noqa: PTH208
            await scenario(engine)
        await until(lambda: all(waited_for(pid) for pid in pids))

    files = 0
    pids: list[int] = []
    asyncio.run(main())


def test_pauses_grow_only_while_no_worker_becomes_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    pauses: list[float] = []
    sleep = asyncio.sleep

    async def noted(seconds: float) -> None:
        pauses.append(seconds)
        await sleep(0.0)

    async def main() -> None:
        async with running(command=rogue("early-death")) as engine:
            monkeypatch.setattr("server.render.engine.asyncio.sleep", noted)
            async with asyncio.timeout(PATIENCE):
                while engine.restarts < 3:
                    await sleep(0.01)
            monkeypatch.undo()

    asyncio.run(main())
    assert [pause for pause in pauses if pause in BACKOFF_SECONDS][:3] == list(BACKOFF_SECONDS[:3])


def test_a_worker_that_never_starts_is_given_up_with_a_word(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.engine.BACKOFF_SECONDS", (0.0,))

    async def main() -> None:
        async with running(command=rogue("early-death")) as engine:
            await until(lambda: engine.activity.state is EngineState.FAILED)
            assert engine.restarts == MOST_STARTS - 1
            assert engine.activity.text.startswith("the renderer could not be started, 5 times; the last: worker ")

    asyncio.run(main())

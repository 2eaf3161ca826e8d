import asyncio
import os
import re
import signal
from time import monotonic

import pytest
from gradient_worker import BUG_LATER_SEED, FAULT_LATER_SEED, HANG_LATER_SEED, HANG_SEED, LONG_SECONDS, LONG_SEED
from harness import PATIENCE, rogue
from live_engine import check, job, result, running, until

from server.render.activity import EngineState
from server.render.engine import Engine
from server.render.quarantine import QuarantinedError
from server.render.schedule import Urgency
from server.render.watch import WATCH_SECONDS
from server.render.worker_link import WorkerLostError


def test_a_worker_that_hangs_is_replaced() -> None:
    async def main() -> None:
        async with running(hang_seconds=0.5) as engine:
            await until(lambda: engine.ready)
            with pytest.raises(WorkerLostError):
                await result(engine, job(seed=HANG_SEED))
            engine._jobs.hang_seconds = PATIENCE
            await result(engine, job())
            assert engine.restarts == 1

    asyncio.run(main())


def test_a_machine_that_stands_still_is_no_hang_of_the_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    stood = 0.0
    monkeypatch.setattr("server.render.watch.monotonic", lambda: monotonic() + stood)

    async def main() -> None:
        nonlocal stood
        async with running(hang_seconds=PATIENCE) as engine:
            await until(lambda: engine.ready)
            await result(engine, job())  # the first heartbeat is over
            assert engine.worker_pid is not None
            os.kill(engine.worker_pid, signal.SIGSTOP)
            reply = await engine.submit(1, Urgency.MOVING, lambda: job())
            assert reply is not None
            stood = 2.0 * PATIENCE
            await asyncio.sleep(2.0 * WATCH_SECONDS)
            os.kill(engine.worker_pid, signal.SIGCONT)
            await reply
            assert engine.restarts == 0

    asyncio.run(main())


def test_long_work_that_reports_progress_is_no_hang() -> None:
    async def main() -> None:
        async with running(hang_seconds=LONG_SECONDS - 0.5) as engine:
            await until(lambda: engine.ready)
            await result(engine, job(seed=LONG_SEED))
            assert engine.restarts == 0

    asyncio.run(main())


def test_a_worker_that_says_nothing_as_it_starts_is_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.watch.FIRST_WORD_SECONDS", 0.3)
    monkeypatch.setattr("server.render.worker_link.STOP_SECONDS", 0.3)

    async def main() -> None:
        async with running(command=rogue("mute")) as engine:
            await until(lambda: engine.restarts > 0)
            assert engine.activity.state is EngineState.RECOVERING

    asyncio.run(main())


@pytest.mark.parametrize("seed", [HANG_LATER_SEED, BUG_LATER_SEED, FAULT_LATER_SEED])
def test_a_fault_that_shows_while_nothing_is_asked_for_is_found(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.watch.HEARTBEAT_SECONDS", 0.2)
    monkeypatch.setattr("server.render.jobs_under_way.HEARTBEAT_DEADLINE", 0.5)

    async def scenario(engine: Engine) -> None:
        await result(engine, job(seed=seed))
        await until(lambda: engine.restarts > 0)
        monkeypatch.undo()  # so that the next one has its time
        await result(engine, job())

    check(scenario)


def test_heartbeats_leave_a_healthy_worker_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.watch.HEARTBEAT_SECONDS", 0.05)

    async def scenario(engine: Engine) -> None:
        await result(engine, job(seed=1))
        busy = engine.busy_seconds
        await until(lambda: engine.busy_seconds > busy)  # a heartbeat has rendered
        await result(engine, job())
        assert engine.restarts == 0

    check(scenario)


def test_a_turn_that_takes_too_long_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario(engine: Engine) -> None:
        assert engine.overdue == ""
        assert engine.worker_pid is not None
        for name, words in (
            ("OVERDUE_SECONDS", "the renderer has said nothing for [0-9]+ s"),
            ("TURN_SECONDS", "one job has had the renderer for [0-9]+ s"),
        ):
            os.kill(engine.worker_pid, signal.SIGSTOP)
            with monkeypatch.context() as short:
                short.setattr("server.render.watch.OVERDUE_SECONDS", PATIENCE)
                short.setattr(f"server.render.watch.{name}", 0.1)
                waiting = asyncio.ensure_future(result(engine, job()))
                await until(lambda words=words: re.fullmatch(words, engine.overdue) is not None)  # type: ignore[misc]
                os.kill(engine.worker_pid, signal.SIGCONT)
                await waiting
                assert engine.overdue == ""

    check(scenario)


def test_a_turn_ends_whatever_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.watch.MOST_TURN_SECONDS", 0.5)

    async def main() -> None:
        async with running(hang_seconds=1.0) as engine:
            await until(lambda: engine.ready)
            with pytest.raises(WorkerLostError):
                await result(engine, job(seed=LONG_SEED))
            engine._jobs.hang_seconds = PATIENCE
            with pytest.raises(QuarantinedError):
                await result(engine, job(seed=LONG_SEED))
            await result(engine, job())

    asyncio.run(main())

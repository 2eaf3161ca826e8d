import asyncio
import os
import re
import signal
from contextlib import suppress
from dataclasses import replace
from time import monotonic

import pytest
from gradient_worker import (
    BUG_LATER_SEED,
    BUG_SEED,
    FAULT_LATER_SEED,
    FAULT_SEED,
    HANG_LATER_SEED,
    HANG_SEED,
    LONG_SECONDS,
    LONG_SEED,
    MEMORY,
    MEMORY_SEED,
    SLOW_SECONDS,
    SLOW_SEED,
    WRONG_SEED,
)
from harness import PATIENCE, rogue
from live_engine import SCENE, check, job, result, running, until

from gpu.errors import OutOfMemoryError, UserError
from server.render.activity import EngineState
from server.render.engine import BACKOFF_SECONDS, MOST_STARTS, WATCH_SECONDS, Engine
from server.render.pending import RenderFaultError
from server.render.quarantine import QuarantinedError
from server.render.schedule import QueueEntry, Urgency
from server.render.worker_link import InnocentLossError, WorkerLostError
from server.wire.worker import Render, SceneRef, Start

KILLS = len(BACKOFF_SECONDS) + 1  # each of them would have to wait longer, were they failures to start


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

        charge = engine._schedule.charge
        monkeypatch.setattr(engine._schedule, "charge", charged)
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


def test_a_killed_worker_is_replaced_and_owes_nothing() -> None:
    async def scenario(engine: Engine) -> None:
        await result(engine, job())  # the first heartbeat is over
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
        await until(lambda: not engine._pending and not engine._waiting)  # the first heartbeat is over
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


def test_a_worker_that_hangs_is_replaced() -> None:
    async def main() -> None:
        async with running(hang_seconds=0.5) as engine:
            await until(lambda: engine.ready)
            with pytest.raises(WorkerLostError):
                await result(engine, job(seed=HANG_SEED))
            engine._hang_seconds = PATIENCE
            await result(engine, job())
            assert engine.restarts == 1

    asyncio.run(main())


def test_a_machine_that_stands_still_is_no_hang_of_the_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    stood = 0.0
    monkeypatch.setattr("server.render.engine.monotonic", lambda: monotonic() + stood)

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
    monkeypatch.setattr("server.render.engine.FIRST_WORD_SECONDS", 0.3)
    monkeypatch.setattr("server.render.worker_link.STOP_SECONDS", 0.3)

    async def main() -> None:
        async with running(command=rogue("mute")) as engine:
            await until(lambda: engine.restarts > 0)
            assert engine.activity.state is EngineState.RECOVERING

    asyncio.run(main())


@pytest.mark.parametrize("seed", [HANG_LATER_SEED, BUG_LATER_SEED, FAULT_LATER_SEED])
def test_a_fault_that_shows_while_nothing_is_asked_for_is_found(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.engine.HEARTBEAT_SECONDS", 0.2)
    monkeypatch.setattr("server.render.engine.HEARTBEAT_DEADLINE", 0.5)

    async def scenario(engine: Engine) -> None:
        await result(engine, job(seed=seed))
        await until(lambda: engine.restarts > 0)
        monkeypatch.undo()  # so that the next one has its time
        await result(engine, job())

    check(scenario)


def test_heartbeats_leave_a_healthy_worker_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.engine.HEARTBEAT_SECONDS", 0.05)

    async def scenario(engine: Engine) -> None:
        await result(engine, job(seed=1))
        busy = engine.busy_seconds
        await until(lambda: engine.busy_seconds > busy)  # a heartbeat has rendered
        await result(engine, job())
        assert engine.restarts == 0

    check(scenario)


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
                short.setattr("server.render.engine.OVERDUE_SECONDS", PATIENCE)
                short.setattr(f"server.render.engine.{name}", 0.1)
                waiting = asyncio.ensure_future(result(engine, job()))
                await until(lambda words=words: re.fullmatch(words, engine.overdue) is not None)  # type: ignore[misc]
                os.kill(engine.worker_pid, signal.SIGCONT)
                await waiting
                assert engine.overdue == ""

    check(scenario)


def test_a_turn_ends_whatever_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.engine.MOST_TURN_SECONDS", 0.5)

    async def main() -> None:
        async with running(hang_seconds=1.0) as engine:
            await until(lambda: engine.ready)
            with pytest.raises(WorkerLostError):
                await result(engine, job(seed=LONG_SEED))
            engine._hang_seconds = PATIENCE
            with pytest.raises(QuarantinedError):
                await result(engine, job(seed=LONG_SEED))
            await result(engine, job())

    asyncio.run(main())


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

import asyncio
import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import pytest
from engines import BOX, FakeEngine
from gradient_worker import DEADLY_SEED, SLOW_SEED
from harness import GRADIENT_WORKER
from live_engine import SCENE, job, until

from server.render.activity import Activity, EngineState
from server.render.engine_pool import LATELY_SECONDS, WEIGH_SECONDS, EnginePool
from server.render.quarantine import QuarantinedError
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.wire.worker import STILLS, Done, Render, SceneRef, Start

HALL = SceneRef("hall.glb", "hall.glb")


class Clock:
    """A time that goes on when a test says so."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


def ready(engine: FakeEngine, state: EngineState = EngineState.READY) -> None:
    engine.set_activity(Activity(state))
    engine.scenes = (BOX,) if state is EngineState.READY else ()


def pool(count: int = 2, clock: Clock | None = None) -> tuple[EnginePool, list[FakeEngine]]:
    """Engines that are ready, and hold one scene."""
    engines = [FakeEngine() for _ in range(count)]
    made = EnginePool(engines, now=clock or Clock())
    for engine in engines:
        ready(engine)
    return made, engines


def test_clients_are_shared_out_and_stay_where_they_are() -> None:
    engines, (first, second) = pool()
    places = [engines.place(client, BOX, Urgency.STILL) for client in (1, 2, 3, 4)]
    assert places == [first, second, first, second]
    assert [engines.place(client, BOX, Urgency.MOVING) for client in (1, 2, 3, 4)] == places
    assert engines.clients_of(first) == {1, 3}
    engines.leave(1)
    assert engines.clients_of(first) == {3}
    assert first.left == [1]


def test_who_wanted_nothing_lately_does_not_count() -> None:
    clock = Clock()
    engines, (first, second) = pool(clock=clock)
    assert engines.place(1, BOX, Urgency.STILL) is first
    clock.seconds += LATELY_SECONDS + 1.0
    assert engines.place(2, BOX, Urgency.STILL) is first
    assert engines.place(3, BOX, Urgency.STILL) is second


def test_a_walker_goes_where_fewer_are_and_leaves_nothing_behind() -> None:
    clock = Clock()
    engines, (first, second) = pool(clock=clock)
    ready(second, EngineState.RECOVERING)
    assert engines.place(1, BOX, Urgency.STILL) is first
    assert engines.place(2, BOX, Urgency.STILL) is first
    ready(second)
    assert engines.place(1, BOX, Urgency.MOVING) is first  # not yet
    clock.seconds += WEIGH_SECONDS
    assert engines.place(1, BOX, Urgency.REFINING) is first  # what it averages is there
    assert engines.place(1, BOX, Urgency.MOVING) is second
    assert first.left == [1]
    clock.seconds += WEIGH_SECONDS
    assert engines.place(2, BOX, Urgency.MOVING) is first


def test_another_scene_is_a_new_choice() -> None:
    engines, (first, second) = pool()
    assert engines.place(1, BOX, Urgency.STILL) is first
    second.scenes = (BOX, HALL)
    assert engines.place(1, HALL, Urgency.STILL) is second
    assert first.left == [1]


def test_a_scene_goes_where_it_fits() -> None:
    engines, (_, second) = pool()
    engines.fits = lambda engine, _: engine is second
    assert engines.place(1, HALL, Urgency.STILL) is second


def test_an_engine_that_comes_back_empty_gets_nobody_else_while_it_loads() -> None:
    engines, (first, second) = pool()
    first.scenes = (BOX, HALL)
    ready(second, EngineState.RECOVERING)
    for client in range(20):
        assert engines.place(client, (BOX, HALL)[client % 2], Urgency.STILL) is first
    ready(second)
    second.scenes = ()
    assert engines.place(100, HALL, Urgency.STILL) is second
    assert engines.place(101, BOX, Urgency.STILL) is first
    assert engines.place(102, HALL, Urgency.STILL) is second  # and waits for the same load
    second.scenes = (HALL,)
    assert engines.place(103, BOX, Urgency.STILL) is second
    ready(second, EngineState.RECOVERING)
    ready(second)
    second.scenes = ()
    assert engines.place(104, HALL, Urgency.STILL) is second  # what it was at is lost


def test_as_many_scenes_are_viewed_on_a_device_as_it_keeps() -> None:
    engines, (first, second) = pool()
    most = first.max_scenes
    for client in range(most):
        first.scenes += (SceneRef(f"{client}.glb", f"{client}.glb"),)
        assert engines.place(1 + client, first.scenes[-1], Urgency.STILL) is first
    second.scenes = ()
    for client in range(most + 2):  # so that it is the more crowded one
        engines.place(100 + client, BOX, Urgency.STILL)
    assert engines.place(50, HALL, Urgency.STILL) is second


def test_stills_go_anywhere_each_time_and_those_that_wait_count() -> None:
    engines, (first, second) = pool()

    async def main() -> None:
        assert engines.place(STILLS, BOX, Urgency.STILL) is first
        assert engines.place(STILLS, BOX, Urgency.STILL) is first
        first._jobs.submit(STILLS, Urgency.STILL, lambda: None, asyncio.get_running_loop().create_future(), None)
        assert engines.place(STILLS, BOX, Urgency.STILL) is second
        assert engines.clients_of(first) == set()

    asyncio.run(main())


def test_what_they_do_together_is_what_the_best_does() -> None:
    engines, (first, second) = pool()
    told: list[EngineState] = []
    engines.listeners.add(lambda: told.append(engines.activity.state))
    ready(first, EngineState.RECOVERING)
    assert engines.ready
    assert engines.activity.state is EngineState.READY
    second.set_activity(Activity(EngineState.READY, "reading hall.glb", 0.5))
    assert engines.activity.text == "reading hall.glb"
    engines.place(1, BOX, Urgency.STILL)
    ready(second, EngineState.RECOVERING)
    assert not engines.ready
    assert told[-1] is EngineState.RECOVERING
    first.set_activity(Activity(EngineState.FAILED, "it is broken"))
    assert engines.activity.state is EngineState.RECOVERING


def test_a_device_that_cannot_be_used_is_said_whatever_others_do() -> None:
    engines, (first, _) = pool()
    first.unusable = True
    first.set_activity(Activity(EngineState.FAILED, "no device 'cuda:9' here"))
    assert engines.activity == Activity(EngineState.FAILED, "no device 'cuda:9' here")


def test_a_client_waits_for_its_own_engine_unless_it_will_go_to_another() -> None:
    engines, (first, second) = pool()
    assert engines.place(1, BOX, Urgency.STILL) is first
    first.set_activity(Activity(EngineState.READY, "reading hall.glb", 0.5))
    assert engines.activity_of(1).text == "reading hall.glb"
    ready(first, EngineState.RECOVERING)
    assert engines.activity_of(1).state is EngineState.READY
    ready(second, EngineState.RECOVERING)
    assert engines.activity_of(1).state is EngineState.RECOVERING


def test_figures_are_of_all_together() -> None:
    engines, (first, second) = pool()
    first.device, second.device = "one (cuda:0)", "two (cuda:1)"
    first.memory, second.memory = (1, 10), (2, 20)
    first.restarts, second.busy_seconds = 3, 4.0
    second.scenes = (BOX, HALL)
    assert engines.device == "one (cuda:0), two (cuda:1)"
    assert (engines.memory, engines.restarts, engines.busy_seconds) == ((3, 30), 3, 4.0)
    assert engines.scenes == (BOX, HALL)
    assert engines.cuda


def test_they_are_overdue_when_all_that_are_ready_are(monkeypatch: pytest.MonkeyPatch) -> None:
    engines, (first, second) = pool()
    monkeypatch.setattr(FakeEngine, "overdue", property(lambda it: "31 s" if it is first else ""))
    assert engines.overdue == ""
    ready(second, EngineState.RECOVERING)
    assert engines.overdue == "31 s"


# --- with workers ---


@asynccontextmanager
async def running() -> AsyncIterator[EnginePool]:
    engines = EnginePool.of(Start(SCENE), ("one", "two"), GRADIENT_WORKER, hang_seconds=20.0)
    task = asyncio.create_task(engines.run())
    try:
        await until(lambda: all(engine.ready for engine in engines.engines))
        yield engines
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def ask(engines: EnginePool, render: Render) -> Done:
    reply = await engines.submit(render.viewer, render.scene, Urgency.MOVING, lambda: render)
    assert reply is not None
    done, _ = await reply
    assert isinstance(done, Done)
    return done


def test_who_waits_for_a_worker_that_dies_gets_a_frame_of_another() -> None:
    async def main() -> None:
        async with running() as engines:
            first, second = engines.engines
            assert engines.place(1, SCENE, Urgency.STILL) is first
            slow = await engines.submit(1, SCENE, Urgency.STILL, lambda: job(1, SLOW_SEED))
            assert slow is not None
            waiting = asyncio.create_task(ask(engines, job(1)))
            await asyncio.sleep(0)
            assert first.worker_pid is not None
            os.kill(first.worker_pid, signal.SIGKILL)
            with pytest.raises(WorkerLostError):
                await slow
            await waiting
            assert engines.clients_of(second) == {1}
            assert (first.restarts, second.restarts) == (1, 0)
            await until(lambda: first.ready)

    asyncio.run(main())


def test_what_ended_one_worker_is_tried_on_no_other() -> None:
    async def main() -> None:
        async with running() as engines:
            first, second = engines.engines
            for _ in range(2):  # one that is killed at once may have been killed by somebody
                with pytest.raises(WorkerLostError):
                    await ask(engines, job(1, DEADLY_SEED))
            with pytest.raises(QuarantinedError):
                await ask(engines, job(1, DEADLY_SEED))
            assert first.restarts + second.restarts <= 2

    asyncio.run(main())

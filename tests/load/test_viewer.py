import asyncio
from time import perf_counter

from harness import Running

from server.wire.browser import Bounds
from server.wire.frame_header import Phase
from tests.load.crowd import measure, plans, wait_for, walking
from tests.load.paths import Recorded, Walk
from tests.load.target import Target
from tests.load.viewer import Log, Plan

SMALL = Plan(size=(96, 54), decode=True)


def walk(target: Target, plan: Plan, seconds: float) -> Log:
    async def visit() -> Log:
        async with walking(target, plan) as viewer:
            await wait_for(lambda: bool(viewer.log.seen), 20.0)
            await asyncio.sleep(seconds)
            return viewer.log

    return asyncio.run(visit())


def test_a_viewer_walks_and_times_each_frame(target: Target) -> None:
    log = walk(target, SMALL, 1.0)
    fresh = [one for one in log.seen if one.arrived is not None]
    assert len(fresh) > 4
    assert len({one.header.pose for one in fresh}) == len(fresh)
    for one in fresh:
        assert one.decoded is not None
        assert one.decode is not None
        assert 0.0 < (one.arrived or 0.0) < one.decoded
    assert (log.errors, log.closed, log.scenes) == ({}, None, 1)


def test_acknowledgements_reach_the_service(running: Running, target: Target) -> None:
    count = "lumenwalk_frame_age_seconds_count"

    def acknowledged() -> float:
        return running.service.metrics.registry.get_sample_value(count) or 0.0

    before = acknowledged()
    log = walk(target, SMALL, 0.5)
    assert acknowledged() - before >= len(log.seen) // 2


def test_who_acknowledges_nothing_soon_gets_nothing(target: Target) -> None:
    log = walk(target, Plan(size=(96, 54), acknowledge=False), 1.0)
    assert 1 <= len(log.seen) <= 3


def test_a_camera_that_rests_is_sent_once_and_gets_sharper(target: Target) -> None:
    view = Walk(Bounds(min=(0.0, 0.0, 0.0), max=(1.0, 1.0, 1.0)), 0).at(0.0)
    log = walk(target, Plan(size=(96, 54), path=lambda bounds, seed: Recorded((0.0,), (view,))), 1.0)
    assert log.poses == 1
    assert log.seen[-1].header.phase is Phase.FINAL
    assert [one.arrived is not None for one in log.seen] == [True] + [False] * (len(log.seen) - 1)


def test_settings_and_scenes_can_be_changed_on_the_way(target: Target) -> None:
    async def visit() -> Log:
        async with walking(target, SMALL) as viewer:
            await wait_for(lambda: bool(viewer.log.seen), 20.0)
            await viewer.change(size=(48, 27))
            await viewer.change(scene="atrium")
            changed = perf_counter()
            await wait_for(lambda: viewer.log.scenes == 2 and viewer.log.last > changed + 0.2, 20.0)
            return viewer.log

    log = asyncio.run(visit())
    assert log.scenes == 2
    assert log.seen[-1].header.settings == 2
    assert log.seen[-1].header.width <= 48


def test_a_crowd_is_measured_together(target: Target) -> None:
    row = asyncio.run(measure(target, plans(SMALL, 3, 1), seconds=1.0, warm_up=0.2))
    assert row["viewers"] == len(row["each"]) == 3
    assert row["fps"]["least"] > 0.0
    assert [bool(one["decoded"]) for one in row["each"]] == [True, False, False]
    assert 0.5 < row["fairness"] <= 1.0
    assert {"renderer", "harness", "web process", "device"} <= set(row["shares"])
    assert row["errors"] == {}


def test_those_who_are_turned_away_are_errors(target: Target) -> None:
    row = asyncio.run(measure(target, plans(SMALL, 7), seconds=0.3, warm_up=0.1))
    assert [error.split(":")[0] for error in row["errors"]] == ["closed with 1013"]

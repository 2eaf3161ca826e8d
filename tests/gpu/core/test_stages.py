from contextlib import nullcontext
from time import sleep
from types import SimpleNamespace

import pytest
import warp as wp
from devices import NEEDS_CUDA

from gpu.adaptive.error_probes import next_probes_kernel
from gpu.core.device import launch
from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time that stages on a CPU go by [s], which passes when it is told to."""
    now = [0.0]
    monkeypatch.setattr("gpu.core.sharing.perf_counter", lambda: now[0])
    return now


def test_stages_run_in_order_and_are_timed_anew_each_frame(clock: list[float]) -> None:
    stages, ran = Stages(wp.get_device("cpu")), []

    def work(number: int) -> None:
        ran.append(number)
        clock[0] += 0.1 * number

    for _ in range(3):
        stages.start_frame()
        stages.run("first", lambda: work(1))
        stages.run("second", lambda: work(2), repeats=False)
    assert ran == [1, 2] * 3
    times = stages.milliseconds()
    assert list(times) == ["first", "second"]
    assert list(times.values()) == pytest.approx([100.0, 200.0])
    stages.start_frame()
    assert stages.milliseconds() == {}


def test_a_frame_is_steady_when_each_stage_has_run_before() -> None:
    stages = Stages(wp.get_device("cpu"))

    def frame(*names: str, repeats: bool = True, branch: int | None = None) -> bool:
        stages.start_frame()
        for name in names:
            stages.run(name, lambda: None, repeats=repeats, branch=branch)
        return stages.steady

    assert [frame("one"), frame("one"), frame("one", "two"), frame("one", "two")] == [False, True, False, True]
    assert [frame("one", repeats=False), frame("one", repeats=False)] == [False, True]
    assert [frame("one", branch=branch) for branch in (1, 1, 2, 1, 2)] == [False, True, False, True, True]


def test_what_follows_runs_each_frame_and_is_no_stage() -> None:
    stages, ran = Stages(wp.get_device("cpu")), []
    for _ in range(2):
        stages.start_frame()
        stages.run("first", lambda: ran.append(1))
        stages.run_untimed(lambda: ran.append(2))
    assert ran == [1, 2] * 2
    assert list(stages.milliseconds()) == ["first"]


def test_what_was_forked_takes_what_the_stage_that_joins_it_takes_longer(clock: list[float]) -> None:
    stages, ran = Stages(wp.get_device("cpu")), []

    def work(number: int) -> None:
        ran.append(number)
        clock[0] += 0.1 * number

    for _ in range(2):
        stages.start_frame()
        stages.run("first", lambda: work(1))
        stages.fork("third", "beside", lambda: work(2))
        stages.run("second", lambda: work(3))
        stages.fork("third", "beside, too", lambda: work(2))
        stages.run("third", lambda: work(4), waits_for_fork=True)
        stages.run("fourth", lambda: work(5))
    assert ran == [1, 2, 3, 2, 4, 5] * 2
    times = stages.milliseconds()
    assert list(times) == ["first", "second", "third", "fourth"]
    assert list(times.values()) == pytest.approx([100.0, 300.0, 800.0, 500.0])


@NEEDS_CUDA
@pytest.mark.parametrize("repeats", [False, True])
def test_what_was_forked_comes_after_the_stages_before_and_before_the_one_that_joins_it(repeats: bool) -> None:
    device, count = wp.get_device("cuda:0"), 1 << 24
    stages = Stages(device)
    one, two, three = (wp.zeros(count, dtype=int, device=device) for _ in range(3))

    def turn(values: wp.array, source: wp.array | None) -> None:
        if source:
            wp.copy(values, source)
        for _ in range(20):
            launch(next_probes_kernel, count, [values], device)

    for frame in range(1, 5):
        stages.start_frame()
        stages.run("one", lambda: turn(one, None), repeats=repeats)
        stages.fork("four", "two", lambda: turn(two, one), repeats=repeats)
        stages.fork("four", "two more", lambda: turn(two, None), repeats=repeats)
        stages.run("three", lambda: turn(three, one), repeats=repeats)
        stages.run("four", lambda: turn(three, two), repeats=repeats, waits_for_fork=True)
        stages.flush()
        wp.synchronize_device(device)
        expected = [20 * frame, 20 * frame + 40, 20 * frame + 60]
        assert [int(values.numpy()[-1]) for values in (one, two, three)] == expected


def test_a_stage_waits_for_what_was_forked_for_it_and_before_but_not_for_what_came_after(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By streams that note what is done in them."""
    done, waits = list[str](), list[object]()
    main, side = (SimpleNamespace(record_event=lambda event: None, wait_event=waits.append) for _ in range(2))
    monkeypatch.setattr(wp, "get_stream", lambda _: main)
    monkeypatch.setattr(wp, "ScopedStream", lambda _: nullcontext())
    monkeypatch.setattr(wp, "Event", lambda *_, **__: object())
    stages = Stages(SimpleNamespace(is_cuda=True), SimpleNamespace(side=side))
    stages.start_frame()
    for name in ("one", "two", "three"):
        stages.fork(name, "beside", lambda: done.append("beside"))

    def stage(name: str) -> None:
        stages.run(name, lambda: done.append(f"{name} after {len(waits)}"), waits_for_fork=True)

    for name in ("two", "one", "four", "three"):
        stage(name)
    stages.fork("four", "beside", lambda: done.append("beside"))
    stages.flush()
    assert done == [*3 * ["beside"], "two after 1", "one after 1", "four after 1", "three after 2", "beside"]
    assert len(set(waits)) == len(waits) == 3  # the last at the end, for what nothing waited for


@NEEDS_CUDA
def test_a_stage_does_not_take_what_was_forked_for_one_after_it() -> None:
    device, count = wp.get_device("cuda:0"), 1 << 24
    stages, values = Stages(device), wp.zeros(count, dtype=int, device=device)

    def turn(times: int) -> None:
        for _ in range(times):
            launch(next_probes_kernel, count, [values], device)

    for _ in range(3):
        stages.start_frame()
        stages.run("first", lambda: turn(1))
        stages.fork("second", "beside", lambda: turn(1))
        stages.fork("third", "beside", lambda: turn(400))
        stages.run("second", lambda: None, waits_for_fork=True)
        stages.run("third", lambda: None, waits_for_fork=True)
        stages.flush()
        wp.synchronize_device(device)
    times = stages.milliseconds()
    assert times["second"] < 5.0 < times["third"]


@NEEDS_CUDA
def test_a_stage_that_joins_takes_what_it_waits_for_but_not_what_its_capture_takes() -> None:
    device, count = wp.get_device("cuda:0"), 1 << 24
    stages, values = Stages(device), wp.zeros(count, dtype=int, device=device)

    def turn(times: int) -> None:
        for _ in range(times):
            launch(next_probes_kernel, count, [values], device)

    def work() -> None:
        sleep(0.5)
        turn(1)

    def frame(beside: int) -> float:
        stages.start_frame()
        stages.run("first", lambda: turn(1))
        stages.fork("second", "beside", lambda: turn(beside), branch=beside)
        stages.run("second", work, waits_for_fork=True)
        stages.flush()
        wp.synchronize_device(device)
        return stages.milliseconds()["second"]

    _loads, captured, replayed = (frame(1) for _ in range(3))
    assert captured < 100.0
    assert replayed < 5.0
    frame(400)
    frame(400)
    assert 5.0 < frame(400) < 100.0


@NEEDS_CUDA
def test_each_variant_of_a_stage_is_captured_once_and_forgotten() -> None:
    device = wp.get_device("cuda:0")
    stages, works = Stages(device), []
    values = {size: wp.zeros(size, dtype=int, device=device) for size in (10, 20)}

    def frame(size: int) -> bool:
        def work() -> None:
            works.append(size)
            launch(next_probes_kernel, size, [values[size]], device)

        stages.start_frame()
        stages.graph_key = (size,)
        stages.run("turn", work)
        stages.flush()
        wp.synchronize_device(device)
        stages.milliseconds()
        return stages.steady

    assert [frame(size) for size in (10, 10, 10, 20, 20, 10)] == [False, True, True, True, True, True]
    assert works == [10, 10, 20]
    assert [int(array.numpy()[-1]) for array in values.values()] == [4, 2]
    stages.forget(20)
    frame(20)
    assert works == [10, 10, 20, 20]
    assert int(values[20].numpy()[0]) == 3


@NEEDS_CUDA
def test_each_way_of_a_stage_is_captured_once() -> None:
    device = wp.get_device("cuda:0")
    stages, works = Stages(device), []
    values = {branch: wp.zeros(10, dtype=int, device=device) for branch in (False, True)}

    def frame(branch: bool) -> None:
        def work() -> None:
            works.append(branch)
            launch(next_probes_kernel, 10, [values[branch]], device)

        stages.start_frame()
        stages.run("turn", work, branch=branch)
        stages.flush()

    for branch in (False, True, True, False, True, False, True):
        frame(branch)
    assert works == [False, True, True, False]
    assert [int(array.numpy()[-1]) for array in values.values()] == [3, 4]


@NEEDS_CUDA
def test_stages_that_follow_one_another_are_one_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    """And a fork that nothing waited for is over when a stage begins that does not repeat."""
    device, count = wp.get_device("cuda:0"), 1 << 24
    stages, graphs, launch_graph = Stages(device), [], wp.capture_launch
    monkeypatch.setattr(wp, "capture_launch", lambda graph: (graphs.append(graph), launch_graph(graph)))
    one, two = (wp.zeros(count, dtype=int, device=device) for _ in range(2))

    def turn(values: wp.array) -> None:
        for _ in range(20):
            launch(next_probes_kernel, count, [values], device)

    for frame in range(1, 6):
        graphs.clear()
        stages.start_frame()
        stages.run("one", lambda: turn(one))
        stages.fork("four", "beside", lambda: turn(two))
        stages.run("two", lambda: turn(one))
        stages.run("three", lambda: wp.copy(one, two), repeats=False)
        stages.run("four", lambda: turn(one), waits_for_fork=True)
        stages.flush()
        wp.synchronize_device(device)
        assert len(graphs) == (2 if frame > 1 else 0)
        assert [int(values.numpy()[-1]) for values in (one, two)] == [20 * frame + 20, 20 * frame]
        assert all(ms >= 0.0 for ms in stages.milliseconds().values())


@NEEDS_CUDA
def test_stepwise_frames_capture_nothing_and_give_the_device_away_between_stages() -> None:
    device = wp.get_device("cuda:0")
    stages, works, given = Stages(device), list[str](), list[int]()
    values = wp.zeros(10, dtype=int, device=device)

    class Always:
        def due(self, *, idle: bool = False) -> bool:
            return True

        def give(self) -> None:
            given.append(len(works))

    def work(name: str) -> None:
        works.append(name)
        launch(next_probes_kernel, 10, [values], device)

    DEVICE_SHARING.begin(Always())
    try:
        stages.stepwise = True
        for _ in range(3):
            stages.start_frame()
            stages.run("first", lambda: work("first"))
            stages.fork("second", "beside", lambda: work("beside"))
            stages.run("second", lambda: work("second"), waits_for_fork=True)
            assert not stages.captured
    finally:
        DEVICE_SHARING.begin(None)
    assert works == ["first", "beside", "second"] * 3
    assert given == list(range(1, 10))
    assert list(stages.milliseconds()) == ["first", "second"]
    assert int(values.numpy()[0]) == 9

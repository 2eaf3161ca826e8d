from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from time import sleep
from types import SimpleNamespace
from typing import Any

import pytest
import warp as wp
from devices import NEEDS_CUDA

from gpu.adaptive.error_probes import next_probes_kernel
from gpu.core import stages as module
from gpu.core.device import launch
from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages
from gpu.core.staging_buffer import StagingBuffer


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


def test_what_runs_beside_stages_comes_after_them_where_nothing_does() -> None:
    stages, ran = Stages(wp.get_device("cpu")), []
    stages.start_frame()
    stages.run("first", lambda: ran.append(1))
    with stages.beside():
        stages.run("second", lambda: ran.append(2))
        ran.append(3)
    stages.run("third", lambda: ran.append(4))
    assert ran == [1, 2, 3, 4]
    assert list(stages.milliseconds()) == ["first", "second", "third"]


class Timed:
    """A stream, or an event, and the time that it has come to [ms]."""

    def __init__(self, *_: object, **__: object) -> None:
        self.now = 0.0

    def record_event(self, event: "Timed") -> None:
        event.now = self.now

    def wait_event(self, event: "Timed") -> None:
        self.now = max(self.now, event.now)

    wait_stream = wait_event


class TimedWarp:
    """Streams of a device on which whatever runs takes the time that it is said to, and nothing is captured."""

    Event = Timed

    def __init__(self) -> None:
        self.current = Timed()

    def take(self, milliseconds: float) -> None:
        self.current.now += milliseconds

    def get_stream(self, _device: object) -> Timed:
        return self.current

    def get_event_elapsed_time(self, begin: Timed, end: Timed, **_: object) -> float:
        return end.now - begin.now

    @contextmanager
    def ScopedStream(self, stream: Timed) -> Iterator[None]:  # noqa: N802
        before, self.current = self.current, stream
        stream.wait_stream(before)
        try:
            yield
        finally:
            self.current = before


@pytest.mark.parametrize(
    ("ahead", "taken", "expected"),
    [
        (3.0, (1.0, 4.0), {"first": 1.0, "ahead": 3.0, "light": 0.0, "more": 2.0, "last": 1.0}),
        (6.0, (1.0, 4.0), {"first": 1.0, "ahead": 6.0, "light": 0.0, "more": 0.0, "last": 1.1}),
        (0.5, (1.0, 4.0), {"first": 1.0, "ahead": 0.5, "light": 0.5, "more": 4.0, "last": 1.0}),
    ],
)
def test_stages_beside_others_begin_with_these_and_take_what_they_take_longer(
    monkeypatch: pytest.MonkeyPatch, ahead: float, taken: tuple[float, float], expected: dict[str, float]
) -> None:
    warp, lane = TimedWarp(), SimpleNamespace(side=Timed(), ahead=Timed())
    monkeypatch.setattr(module, "wp", warp)
    stages: Any = Stages(SimpleNamespace(is_cuda=True), lane)
    monkeypatch.setattr(stages, "_note", lambda key: stages._loaded.discard(key))  # it is never captured
    for _ in range(2):
        begun = warp.current.now
        stages.start_frame()
        stages.run("first", lambda: warp.take(1.0))
        stages.flush()
        stages.run("ahead", lambda: warp.take(ahead))
        stages.fork("last", "beside", lambda: warp.take(0.1))
        with suppress(KeyError), stages.beside():
            for name, milliseconds in zip(("light", "more"), taken, strict=True):
                stages.run(name, lambda milliseconds=milliseconds: warp.take(milliseconds))
                stages.flush()
            assert warp.current.now == begun + 1.0 + sum(taken)
            raise KeyError  # the frame's next stages, or the next frame, come after both all the same
        stages.run("last", lambda: warp.take(1.0), waits_for_fork=True)
        stages.flush()
        assert stages.milliseconds() == pytest.approx(expected)
        assert warp.current.now - begun == pytest.approx(sum(expected.values()))


def test_what_is_forked_apart_waits_for_nothing_else_that_was_forked(monkeypatch: pytest.MonkeyPatch) -> None:
    warp, streams = TimedWarp(), {"third": Timed(), "fifth": Timed()}
    lane = SimpleNamespace(side=Timed(), apart=streams.__getitem__)
    monkeypatch.setattr(module, "wp", warp)
    stages: Any = Stages(SimpleNamespace(is_cuda=True), lane)
    stages.start_frame()
    stages.run("first", lambda: warp.take(1.0))
    stages.fork("fourth", "beside", lambda: warp.take(8.0))
    stages.fork("third", "apart", lambda: warp.take(2.0), apart=True)
    stages.run("second", lambda: warp.take(1.0))
    stages.fork("third", "apart, too", lambda: warp.take(1.0), apart=True)
    stages.run("third", lambda: warp.take(1.0), waits_for_fork=True)
    stages.run("fourth", lambda: warp.take(1.0), waits_for_fork=True)
    stages.fork("fifth", "apart", lambda: warp.take(2.0), apart=True)
    stages.flush()
    assert stages.milliseconds() == pytest.approx({"first": 1.0, "second": 1.0, "third": 3.0, "fourth": 5.0})
    assert warp.current.now == 12.0  # what nothing waited for


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
@pytest.mark.parametrize("repeats", [False, True])
def test_what_runs_beside_stages_is_waited_for_alone_and_both_come_before_what_follows(repeats: bool) -> None:
    device, count = wp.get_device("cuda:0"), 1 << 24
    stages, late = Stages(device), list[bool]()
    one, two, three = (wp.zeros(count, dtype=int, device=device) for _ in range(3))
    last = StagingBuffer(two[-1:])

    def turn(values: wp.array, times: int) -> None:
        for _ in range(times):
            launch(next_probes_kernel, count, [values], device)

    def both() -> None:
        wp.copy(three, one)
        turn(two, 1)

    for frame in range(1, 6):
        stages.start_frame()
        stages.run("one", lambda: turn(one, 400), repeats=repeats)
        over = wp.get_stream(device) if repeats is False else stages._lane.ahead
        with stages.beside():
            stages.run("two", lambda: turn(two, 1))
            stages.flush()
            last.download()
            wp.synchronize_stream(device)
            assert last.host[0] == 2 * frame - 1
            late.append(not over.is_complete)
        stages.run("three", both)
        stages.flush()
        wp.synchronize_device(device)
        assert [int(values.numpy()[-1]) for values in (one, two, three)] == [400 * frame, 2 * frame, 400 * frame]
        times = stages.milliseconds()
        assert list(times) == ["one", "two", "three"]
        assert 0.0 <= times["two"] < times["one"]
    assert late[-1] == repeats


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

import pytest
import warp as wp

from gpu.device import launch
from gpu.probes import turn_kernel
from gpu.stages import Stages


def test_stages_run_in_order_and_are_timed_anew_each_frame() -> None:
    stages, ran = Stages(wp.get_device("cpu")), []
    for _ in range(3):
        stages.start_frame()
        stages.run("first", lambda: ran.append(1))
        stages.run("second", lambda: ran.append(2), repeats=False)
    assert ran == [1, 2] * 3
    times = stages.milliseconds()
    assert list(times) == ["first", "second"]
    assert all(0.0 <= ms < 1000.0 for ms in times.values())
    stages.start_frame()
    assert stages.milliseconds() == {}


def test_a_frame_is_steady_when_each_stage_has_run_before() -> None:
    stages = Stages(wp.get_device("cpu"))

    def frame(*names: str, repeats: bool = True, way: int | None = None) -> bool:
        stages.start_frame()
        for name in names:
            stages.run(name, lambda: None, repeats=repeats, way=way)
        return stages.steady

    assert [frame("one"), frame("one"), frame("one", "two"), frame("one", "two")] == [False, True, False, True]
    assert [frame("one", repeats=False), frame("one", repeats=False)] == [False, True]
    assert [frame("one", way=way) for way in (1, 1, 2, 1, 2)] == [False, True, False, True, True]


@pytest.mark.skipif(not wp.is_cuda_available(), reason="graphs are CUDA's")
def test_each_variant_of_a_stage_is_captured_once_and_forgotten() -> None:
    device = wp.get_device("cuda:0")
    stages, works = Stages(device), []
    values = {size: wp.zeros(size, dtype=int, device=device) for size in (10, 20)}

    def frame(size: int) -> bool:
        def work() -> None:
            works.append(size)
            launch(turn_kernel, size, [values[size]], device)

        stages.start_frame()
        stages.variant = size
        stages.run("turn", work)
        stages.milliseconds()
        return stages.steady

    assert [frame(size) for size in (10, 10, 10, 20, 20, 10)] == [False, True, True, True, True, True]
    assert works == [10, 10, 20]
    assert [int(array.numpy()[-1]) for array in values.values()] == [4, 2]
    stages.forget(20)
    frame(20)
    assert works == [10, 10, 20, 20]
    assert int(values[20].numpy()[0]) == 3


@pytest.mark.skipif(not wp.is_cuda_available(), reason="graphs are CUDA's")
def test_each_way_of_a_stage_is_captured_once() -> None:
    device = wp.get_device("cuda:0")
    stages, works = Stages(device), []
    values = {way: wp.zeros(10, dtype=int, device=device) for way in (False, True)}

    def frame(way: bool) -> None:
        def work() -> None:
            works.append(way)
            launch(turn_kernel, 10, [values[way]], device)

        stages.start_frame()
        stages.run("turn", work, way=way)
        stages.milliseconds()

    for way in (False, True, True, False, True, False, True):
        frame(way)
    assert works == [False, True, True, False]
    assert [int(array.numpy()[-1]) for array in values.values()] == [3, 4]

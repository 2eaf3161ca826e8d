from time import perf_counter
from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA, wait_kernel

from gpu.core import lane as module
from gpu.core.device import choose_device, launch
from gpu.core.lane import CUDA_FRAMES, Flight, Lane, frames_at_once


def test_a_cpu_has_one_lane_where_all_is_over_at_once() -> None:
    device = wp.get_device("cpu")
    lane = Lane(device)
    with lane.entered():
        pass
    assert frames_at_once(device) == 1
    assert lane.flight().is_over()
    lane.flight().wait()


@pytest.mark.parametrize(("gigabytes", "lanes"), [(80, CUDA_FRAMES), (24, 4), (16, 3), (4, 1)])
def test_a_gpu_has_as_many_lanes_as_its_memory_has_room_for(gigabytes: int, lanes: int) -> None:
    assert frames_at_once(SimpleNamespace(is_cuda=True, total_memory=gigabytes << 30)) == lanes


class Never:
    """An event that is never reached."""

    is_complete = False


class Stream:
    def record_event(self, event: object) -> Never:
        return Never()


def test_what_is_late_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(module, "perf_counter", lambda: now[0])
    monkeypatch.setattr(wp, "Event", lambda device: None)
    flight = Flight(wp.get_device("cpu"), Stream())
    assert not flight.is_over()
    now[0] += 1.01 * module.LATE_SECONDS
    assert flight.is_over()


@NEEDS_CUDA
def test_lanes_run_at_once_and_after_what_the_device_was_given_before() -> None:
    device = choose_device("cuda:0")
    lanes, values = [Lane(device) for _ in range(4)], wp.zeros(4, dtype=float, device=device)
    parts = [values[index : index + 1] for index in range(4)]

    def seconds(number: int) -> float:
        begun = perf_counter()
        for lane, part in zip(lanes[:number], parts, strict=False):
            with lane.entered():
                launch(wait_kernel, 1, [1 << 20, part], device)
        flights = [lane.flight() for lane in lanes]
        assert not flights[0].is_over()
        for flight in flights:
            flight.wait()
        assert all(flight.is_over() for flight in flights)
        return perf_counter() - begun

    seconds(4)  # loads the kernel
    alone = min(seconds(1) for _ in range(3))
    assert min(seconds(4) for _ in range(3)) < 2.0 * alone
    values.fill_(5.0)
    with lanes[0].entered():
        launch(wait_kernel, 1, [0, parts[0]], device)
    lanes[0].flight().wait()
    assert np.array_equal(values.numpy()[:1], [6.0])

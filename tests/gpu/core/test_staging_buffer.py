import numpy as np
import pytest
import warp as wp
from devices import DEVICES, NEEDS_CUDA

from gpu.core.staging_buffer import StagingBuffer


@pytest.mark.parametrize("device", DEVICES)
def test_values_go_to_the_device_and_back(device: str) -> None:
    mirror = StagingBuffer(wp.zeros((2, 3), dtype=int, device=device))
    assert (mirror.host == 0).all()
    mirror.host[:] = np.arange(6).reshape(2, 3)
    mirror.upload()
    wp.synchronize_device(device)
    mirror.host[:] = 0
    assert (mirror.array.numpy() == np.arange(6).reshape(2, 3)).all()
    mirror.download()
    wp.synchronize_device(device)
    assert (mirror.host == np.arange(6).reshape(2, 3)).all()


@NEEDS_CUDA
def test_captured_copies_take_the_values_of_each_replay() -> None:
    mirror = StagingBuffer(wp.zeros(1, dtype=int, device="cuda:0"))
    with wp.ScopedCapture("cuda:0") as capture:
        mirror.upload()
        mirror.array += 1
        mirror.download()
    for value in (3, 7):
        mirror.host[0] = value
        wp.capture_launch(capture.graph)
        wp.synchronize_device("cuda:0")
        assert mirror.host[0] == value + 1

import numpy as np
import pytest
import warp as wp

from gpu.core.device import MIN_SLICE, allocate, choose_device, duplicate, launch
from gpu.errors import DeviceError
from gpu.lights.light_paths import Vpls


@wp.kernel
def count_kernel(first: int, visits: wp.array[int]) -> None:
    """One thread an item: counts its visits."""
    item = first + wp.tid()
    visits[item] += 1


def test_an_unknown_device_is_refused_with_those_there_are() -> None:
    with pytest.raises(DeviceError, match="cpu"):
        choose_device("cuda:77")


@pytest.mark.parametrize("count", [0, 1, MIN_SLICE - 1, MIN_SLICE + 1, 50_001])
def test_a_launch_visits_every_item_once(count: int) -> None:
    visits = wp.zeros(max(count, 1), dtype=int, device="cpu")
    launch(count_kernel, count, [visits], choose_device("cpu"))
    assert (visits.numpy()[:count] == 1).all()


def test_allocate_makes_every_array_and_duplicate_shares_them() -> None:
    vpls = allocate(Vpls, 3, choose_device("cpu"))
    vpls.count = 3
    other = duplicate(Vpls, vpls)
    other.count = 2
    assert vpls.count == 3
    assert np.array_equal(vpls.flux.numpy(), np.zeros((3, 3)))
    assert other.flux.ptr == vpls.flux.ptr

"""What threads that run together share."""

import numpy as np
import pytest
import warp as wp
from devices import DEVICES, NEEDS_CUDA

from gpu.core.intrinsics import bits_of_warp, float_least, lanes_of, place_of_least, room_in

WARP = 32


@wp.kernel
def together_kernel(bits: wp.array[wp.uint32], out: wp.array[wp.uint32]) -> None:
    """One thread a word."""
    index = wp.tid()
    out[index] = bits_of_warp(bits[index])


def together(bits: np.ndarray, device: wp.Device | str) -> np.ndarray:
    out = wp.zeros(len(bits), dtype=wp.uint32, device=device)
    wp.launch(together_kernel, len(bits), [wp.array(bits, dtype=wp.uint32, device=device), out], device=device)
    return np.asarray(out.numpy())


def words() -> np.ndarray:
    return (np.uint32(1) << np.random.default_rng(0).integers(0, 32, 4 * WARP).astype(np.uint32)).astype(np.uint32)


def test_a_thread_has_its_own_bits() -> None:
    assert np.array_equal(together(words(), "cpu"), words())


@NEEDS_CUDA
def test_threads_of_a_warp_have_the_bits_of_all_on_cuda() -> None:
    bits = words()
    whole = np.bitwise_or.reduce(bits.reshape(-1, WARP), axis=1)
    found = together(bits, "cuda:0").reshape(-1, WARP)
    assert (found & bits.reshape(-1, WARP) == bits.reshape(-1, WARP)).all()
    assert (found | whole[:, None] == whole[:, None]).all()


@wp.kernel
def room_kernel(numbers: wp.array[int], ends: wp.array[int], begins: wp.array[int]) -> None:
    """One thread an item that needs room, every third does not come."""
    index = wp.tid()
    if index % 3 == 0:
        return
    begins[index] = room_in(ends, 1, numbers[index])


@pytest.mark.parametrize("device", DEVICES)
def test_each_has_room_of_its_own_and_none_is_left(device: str) -> None:
    numbers = np.random.default_rng(0).integers(0, 33, 1000).astype(np.int32)
    ends, begins = (wp.array(values, dtype=int, device=device) for values in ([5, 7], np.full(1000, -1)))
    wp.launch(room_kernel, 1000, [wp.array(numbers, dtype=int, device=device), ends, begins], device=device)
    came = np.arange(1000) % 3 != 0
    assert ends.numpy().tolist() == [5, 7 + numbers[came].sum()]
    taken = [np.arange(number) + begin for number, begin in zip(numbers[came], begins.numpy()[came], strict=True)]
    assert np.array_equal(np.sort(np.concatenate(taken)), np.arange(7, ends.numpy()[1]))
    assert (begins.numpy()[~came] == -1).all()


@wp.kernel
def least_kernel(values: wp.array[float], lanes: int, least: wp.array[float], places: wp.array[int]) -> None:
    """One thread a value: the least of its item, and which it is."""
    index = wp.tid()
    least[index] = float_least(values[index], lanes)
    places[index] = place_of_least(values[index], index, lanes)


@pytest.mark.parametrize("device", DEVICES)
def test_lanes_find_their_least_value_and_the_first_that_has_it(device: str) -> None:
    lanes = lanes_of(wp.get_device(device), few=True)
    values = np.random.default_rng(1).integers(0, 5, 800).astype(np.float32)
    items = values.reshape(-1, lanes)
    least, places = (wp.zeros(800, dtype=kind, device=device) for kind in (float, int))
    wp.launch(least_kernel, 800, [wp.array(values, dtype=float, device=device), lanes, least, places], device=device)
    assert np.array_equal(least.numpy(), np.repeat(items.min(axis=1), lanes))
    first = np.arange(0, 800, lanes) + items.argmin(axis=1)
    assert np.array_equal(places.numpy(), np.repeat(first, lanes))

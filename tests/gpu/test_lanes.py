"""What threads that run together share."""

import numpy as np
import pytest
import warp as wp

from gpu.lanes import bits_of_warp

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


@pytest.mark.skipif(not wp.is_cuda_available(), reason="needs a CUDA device")
def test_threads_of_a_warp_have_the_bits_of_all_on_cuda() -> None:
    bits = words()
    whole = np.bitwise_or.reduce(bits.reshape(-1, WARP), axis=1)
    found = together(bits, "cuda:0").reshape(-1, WARP)
    assert (found & bits.reshape(-1, WARP) == bits.reshape(-1, WARP)).all()
    assert (found | whole[:, None] == whole[:, None]).all()

"""The devices that tests run on: the CPU, and a CUDA device where there is one, and what keeps that busy."""

import pytest
import warp as wp

NEEDS_CUDA = pytest.mark.cuda
DEVICES = ["cpu", pytest.param("cuda:0", marks=NEEDS_CUDA)]


@wp.kernel
def wait_kernel(first: int, rounds: int, values: wp.array[float]) -> None:
    """One thread a number: a while of work."""
    index = first + wp.tid()
    x = float(1.0)
    for _round in range(rounds):
        x = wp.sin(x) + 1.0
    values[index] += x

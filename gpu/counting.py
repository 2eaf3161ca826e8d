"""Sums over device arrays for a frame's statistics, without atomics: the same result in any order of threads."""

import warp as wp

from gpu.device import launch

PARTIALS = 1024


@wp.kernel
def sum_kernel(first: int, values: wp.array[int], least: int, partials: wp.array[int]) -> None:
    """One thread a partial sum over every PARTIALS-th value; values below `least` do not count."""
    partial = first + wp.tid()
    total = int(0)
    index = int(partial)
    while index < values.shape[0]:
        total += wp.where(values[index] >= least, values[index], 0)
        index += PARTIALS
    partials[partial] = total


class Counter:
    """Sums int arrays of a device; its own array is allocated once."""

    def __init__(self, device: wp.Device) -> None:
        self.device = device
        self._partials = wp.zeros(PARTIALS, dtype=int, device=device)

    def sum(self, values: wp.array, least: int = 0) -> int:
        """Sum of those elements of `values`, an array of non-negative ints, that are `least` or more."""
        launch(sum_kernel, PARTIALS, [values, least, self._partials], self.device)
        return int(self._partials.numpy().sum(dtype="int64"))

"""Sums over device arrays for a frame's statistics, without atomics: the same result in any order of threads."""

from collections.abc import Sequence

import warp as wp

from gpu.device import launch
from gpu.mirror import Mirror

# A GPU's threads, each with few values; their sums are summed on the device once more before they travel.
PARTIALS = 16_384
SUMS = 128


@wp.kernel
def sum_kernel(first: int, values: wp.array[int], least: int, row: int, partials: wp.array2d[int]) -> None:
    """One thread a partial sum over every PARTIALS-th value; values below `least` do not count."""
    partial = first + wp.tid()
    total = int(0)
    index = int(partial)
    while index < values.shape[0]:
        total += wp.where(values[index] >= least, values[index], 0)
        index += PARTIALS
    partials[row, partial] = total


@wp.kernel
def count_kernel(first: int, values: wp.array[int], value: int, row: int, partials: wp.array2d[int]) -> None:
    """One thread a partial count over every PARTIALS-th value of those that are `value`."""
    partial = first + wp.tid()
    total = int(0)
    index = int(partial)
    while index < values.shape[0]:
        total += wp.where(values[index] == value, 1, 0)
        index += PARTIALS
    partials[row, partial] = total


@wp.kernel
def fold_kernel(first: int, partials: wp.array2d[int], sums: wp.array2d[int]) -> None:
    """One thread a sum in a row: over every SUMS-th of its partial sums."""
    index = first + wp.tid()
    row = index // SUMS
    total = int(0)
    for partial in range(index % SUMS, PARTIALS, SUMS):
        total += partials[row, partial]
    sums[row, index % SUMS] = total


class Counter:
    """Sums or counts in up to `rows` int arrays of a device at a time; its own arrays are allocated once."""

    def __init__(self, rows: int, device: wp.Device) -> None:
        self.device = device
        self._partials = wp.zeros((rows, PARTIALS), dtype=int, device=device)
        self._sums = Mirror(wp.zeros((rows, SUMS), dtype=int, device=device))

    def run(self, arrays: Sequence[tuple[wp.array, int]], counted: Sequence[tuple[wp.array, int]] = ()) -> None:
        """For each (values, least) sum those non-negative values that are `least` or more; at most `rows` in all.

        Then, for each (values, value) of `counted`, count how many are `value`.
        """
        for row, (values, least) in enumerate(arrays):
            launch(sum_kernel, PARTIALS, [values, least, row, self._partials], self.device)
        for row, (values, value) in enumerate(counted, start=len(arrays)):
            launch(count_kernel, PARTIALS, [values, value, row, self._partials], self.device)
        launch(fold_kernel, self._sums.array.size, [self._partials, self._sums.array], self.device)
        self._sums.download()

    def totals(self) -> list[int]:
        """What the last run, which is ready, found, for all rows: those that it did not need have older ones."""
        return [int(total) for total in self._sums.host.sum(axis=1, dtype="int64")]

"""Sums over device arrays for a frame's statistics, without atomics: the same result in any order of threads."""

from collections.abc import Sequence

import warp as wp

from gpu.core.device import launch
from gpu.core.staging_buffer import StagingBuffer

# Threads of the first pass, each with few values; a second pass on the device leaves SUMS to download.
PARTIALS = 16_384
SUMS = 1024
READ = 8
LARGEST = (1 << 31) - 1
Some = wp.types.vector(length=READ, dtype=int)


@wp.kernel
def sum_ints_kernel(first: int, values: wp.array[int], least: int, most: int, counts: bool, row: int,
                    partials: wp.array2d[int]) -> None:  # fmt: skip
    """One thread a partial sum over every PARTIALS-th value from `least` to `most`; counts: of 1 for each of these.

    READ values are read before one is used: a thread waits for memory most of the time.
    """
    partial = first + wp.tid()
    some = Some()
    total = int(0)
    index = int(partial)
    while index < values.shape[0]:
        for number in range(wp.static(READ)):
            place = index + number * PARTIALS
            some[number] = least - 1
            if place < values.shape[0]:
                some[number] = values[place]
        for number in range(wp.static(READ)):
            if some[number] >= least and some[number] <= most:
                total += wp.where(counts, 1, some[number])
        index += wp.static(READ) * PARTIALS
    partials[row, partial] = total


@wp.kernel
def fold_int_sums_kernel(first: int, partials: wp.array2d[int], sums: wp.array2d[int]) -> None:
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
        self._sums = StagingBuffer(wp.zeros((rows, SUMS), dtype=int, device=device))

    def run(self, arrays: Sequence[tuple[wp.array, int]], counted: Sequence[tuple[wp.array, int]] = ()) -> None:
        """For each (values, least) sum those non-negative values that are `least` or more; at most `rows` in all.

        Then, for each (values, value) of `counted`, count how many are `value`.
        """
        for row, (values, least) in enumerate(arrays):
            launch(sum_ints_kernel, PARTIALS, [values, least, LARGEST, False, row, self._partials], self.device)
        for row, (values, value) in enumerate(counted, start=len(arrays)):
            launch(sum_ints_kernel, PARTIALS, [values, value, value, True, row, self._partials], self.device)
        launch(fold_int_sums_kernel, self._sums.array.size, [self._partials, self._sums.array], self.device)
        self._sums.download()

    def totals(self) -> list[int]:
        """What the last run, which is ready, found, for all rows: those that it did not need have older ones."""
        return [int(total) for total in self._sums.host.sum(axis=1, dtype="int64")]

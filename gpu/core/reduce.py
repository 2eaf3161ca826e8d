"""Sums over device arrays for a frame's statistics, without atomics: the same result in any order of threads."""

from collections.abc import Sequence
from typing import Any

import warp as wp

from gpu.core.device import launch
from gpu.core.staging_buffer import StagingBuffer

# Threads of the first pass, each with few values; a second pass on the device leaves SUMS to download.
PARTIALS = 16_384
SUMS = 1024
READ = 8
LARGEST = (1 << 31) - 1
MOST_ROWS = 16
Some = wp.types.vector(length=READ, dtype=int)
Numbers: Any = wp.types.vector(length=MOST_ROWS, dtype=int)
Addresses: Any = wp.types.vector(length=MOST_ROWS, dtype=wp.uint64)


@wp.struct
class Rows:
    """What is summed up, (row,) each. address, length: of int arrays; least, most: of values that count; counted: 1
    where these count 1, else 0.
    """

    address: Addresses
    length: Numbers
    least: Numbers
    most: Numbers
    counted: Numbers


@wp.kernel
def sum_ints_kernel(first: int, rows: Rows, partials: wp.array2d[int]) -> None:
    """One thread a partial sum of a row over every PARTIALS-th of its values: partials (row, PARTIALS).

    READ values are read before one is used: a thread waits for memory most of the time.
    """
    thread = first + wp.tid()
    row = thread // PARTIALS
    partial = thread % PARTIALS
    values = wp.array(ptr=rows.address[row], shape=(rows.length[row],), dtype=int)
    least = rows.least[row]
    most = rows.most[row]
    counts = rows.counted[row] == 1
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
    """One thread a sum in a row: over every SUMS-th of its partial sums; partials (row, PARTIALS), sums (row, SUMS)."""
    index = first + wp.tid()
    row = index // SUMS
    total = int(0)
    for partial in range(index % SUMS, PARTIALS, SUMS):
        total += partials[row, partial]
    sums[row, index % SUMS] = total


class Counter:
    """Sums or counts in up to `rows` int arrays of a device at a time, 16 at the most; its own arrays are allocated
    once.
    """

    def __init__(self, rows: int, device: wp.Device) -> None:
        self.device = device
        self._partials = wp.zeros((rows, PARTIALS), dtype=int, device=device)
        self._sums = StagingBuffer(wp.zeros((rows, SUMS), dtype=int, device=device))

    def run(self, arrays: Sequence[tuple[wp.array, int]], counted: Sequence[tuple[wp.array, int]] = ()) -> None:
        """For each (values, least) sum those non-negative values that are `least` or more; at most `rows` in all.

        Then, for each (values, value) of `counted`, count how many are `value`.
        """
        rows = Rows()
        whole = [(values, least, LARGEST, 0) for values, least in arrays]
        whole += [(values, value, value, 1) for values, value in counted]
        for row, (values, *numbers) in enumerate(whole):
            rows.address[row], rows.length[row] = values.ptr or 0, len(values)
            rows.least[row], rows.most[row], rows.counted[row] = numbers
        launch(sum_ints_kernel, PARTIALS * len(whole), [rows, self._partials], self.device)
        launch(fold_int_sums_kernel, self._sums.array.size, [self._partials, self._sums.array], self.device)
        self._sums.download()

    def totals(self) -> list[int]:
        """What the last run, which is ready, found, for all rows: those that it did not need have older ones."""
        return [int(total) for total in self._sums.host.sum(axis=1, dtype="int64")]

"""What SP clusters know, handed on to another number of them: so a walk goes on where its counts change.

As many stay as there is room for, evenly many of them where there is less; the others are free. Beyond the 2022 paper,
whose future work are counts that are chosen for a wanted time.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import warp as wp

from gpu.device import launch

# A thread has so many values of a table, as far apart as there are threads that run together: those write side by side.
LANES, EACH = 32, 8
Places = wp.types.vector(length=EACH, dtype=int)
Values = wp.types.vector(length=EACH, dtype=wp.uint32)


class Table(NamedTuple):
    """An array that has values of four bytes, or vectors of these, of clusters, which are its `axis`.

    clears: free clusters have 0 there; else nobody reads what they have.
    """

    values: wp.array
    axis: int = 0
    clears: bool = True


@wp.struct
class Handover:
    """A table to fill from another, by their addresses, and the first of all tables' values that is its own.

    Of its `size` values, `count` clusters have `along` side by side in every row, of which the first `filled` are
    filled; of the other table's `known` ones `before` clusters have as many.
    """

    source: wp.uint64
    target: wp.uint64
    begin: int
    size: int
    known: int
    count: int
    filled: int
    before: int
    along: int


@wp.func
def origin_of(cluster: int, count: int, before: int) -> int:
    """Which of the `before` clusters becomes this one of `count`, −1 for none."""
    if count >= before:
        return wp.where(cluster < before, cluster, -1)
    return int(wp.int64(cluster) * wp.int64(before) / wp.int64(count))


@wp.kernel
def carry_kernel(first: int, handovers: wp.array[Handover], numbers: wp.array[int]) -> None:
    """One thread EACH values of a target: those of the clusters where they come from, 0 for free ones.

    numbers (run,): the handover of each LANES · EACH values. All places are known before the first value is read, and
    all values are read before one is written: else each would wait for the one before.
    """
    thread = first + wp.tid()
    handover = handovers[numbers[thread // LANES]]
    source = wp.array(ptr=handover.source, shape=(handover.known,), dtype=wp.uint32)
    target = wp.array(ptr=handover.target, shape=(handover.size,), dtype=wp.uint32)
    index = thread // LANES * LANES * EACH + thread % LANES - handover.begin
    row = index // handover.along // handover.filled
    cluster = index // handover.along - row * handover.filled
    offset = index % handover.along
    origins = Places()
    places = Places()
    values = Values()
    for value in range(wp.static(EACH)):
        places[value] = (row * handover.count + cluster) * handover.along + offset
        origin = origin_of(cluster, handover.count, handover.before)
        origins[value] = (row * handover.before + origin) * handover.along + offset
        if origin < 0 or places[value] >= handover.size:
            origins[value] = -1
        if handover.along == 1:
            cluster += LANES
        else:
            offset += LANES
            while offset >= handover.along:
                offset -= handover.along
                cluster += 1
        while cluster >= handover.filled:
            cluster -= handover.filled
            row += 1
    for value in range(wp.static(EACH)):
        if origins[value] >= 0:
            values[value] = source[origins[value]]
    for value in range(wp.static(EACH)):
        if places[value] < handover.size:
            target[places[value]] = values[value]


class Carrying:
    """Fills `targets` with what as many `sources` know of clusters, in one launch, whose list is made beforehand."""

    def __init__(self, sources: Sequence[Table], targets: Sequence[Table], device: wp.Device) -> None:
        self.device = device
        # The addresses must stay true.
        self._tables = *sources, *targets
        handovers, runs, run = [], list[int](), LANES * EACH
        for source, target in zip(sources, targets, strict=True):
            handover = Handover()
            handover.source, handover.target = wp.uint64(source.values.ptr), wp.uint64(target.values.ptr)
            handover.before, handover.count = (table.values.shape[table.axis] for table in (source, target))
            handover.filled = handover.count if target.clears else min(handover.count, handover.before)
            handover.known, handover.size = (table.values.capacity // 4 for table in (source, target))
            handover.begin = run * sum(runs)
            rows = target.values.shape[0] if target.axis == 1 else 1
            handover.along = handover.size // (handover.count * rows)
            handovers.append(handover)
            runs.append(-(-rows * handover.filled * handover.along // run))
        self._threads = LANES * sum(runs)
        self._handovers = wp.array(handovers, dtype=Handover, device=device)
        self._numbers = wp.array(np.repeat(np.arange(len(runs)), runs), dtype=int, device=device)

    def run(self) -> None:
        """Fill the targets."""
        launch(carry_kernel, self._threads, [self._handovers, self._numbers], self.device)

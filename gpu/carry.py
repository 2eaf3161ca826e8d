"""What SP clusters know, handed on to another number of them: so a walk goes on where its counts change.

As many stay as there is room for, evenly many of them where there is less; the others are free. Beyond the 2022 paper,
whose future work are counts that are chosen for a wanted time.
"""

from collections.abc import Sequence
from typing import NamedTuple

import warp as wp

from gpu.device import launch


class Table(NamedTuple):
    """An array that has values of four bytes, or vectors of these, of clusters, which are its `axis`."""

    values: wp.array
    axis: int = 0


@wp.struct
class Handover:
    """A table to fill from another, by their addresses, and the first of the kernel's values that is its own.

    count, before: clusters of both; along: values of each cluster that lie side by side in every row.
    """

    source: wp.uint64
    target: wp.uint64
    begin: int
    count: int
    before: int
    along: int


@wp.func
def origin_of(cluster: int, count: int, before: int) -> int:
    """Which of the `before` clusters becomes this one of `count`, −1 for none."""
    if count >= before:
        return wp.where(cluster < before, cluster, -1)
    return int(wp.int64(cluster) * wp.int64(before) / wp.int64(count))


@wp.kernel
def carry_kernel(first: int, handovers: wp.array[Handover]) -> None:
    """One thread a value of all targets: that of the cluster where it comes from, 0 for a free one."""
    index = first + wp.tid()
    number = int(0)
    while number < handovers.shape[0] - 1 and index >= handovers[number + 1].begin:
        number += 1
    handover = handovers[number]
    index -= handover.begin
    along = handover.along
    row = index // (handover.count * along)
    origin = origin_of((index // along) % handover.count, handover.count, handover.before)
    value = wp.uint32(0)
    if origin >= 0:
        place = (row * handover.before + origin) * along + index % along
        source = wp.array(ptr=handover.source, shape=(place + 1,), dtype=wp.uint32)
        value = source[place]
    target = wp.array(ptr=handover.target, shape=(index + 1,), dtype=wp.uint32)
    target[index] = value


class Carrying:
    """Fills `targets` with what as many `sources` know of clusters, in one launch, whose list is made beforehand."""

    def __init__(self, sources: Sequence[Table], targets: Sequence[Table], device: wp.Device) -> None:
        self.device, self._size = device, 0
        # The addresses must stay true.
        self._tables = *sources, *targets
        handovers = []
        for source, target in zip(sources, targets, strict=True):
            handover = Handover()
            handover.source, handover.target = wp.uint64(source.values.ptr), wp.uint64(target.values.ptr)
            handover.before, handover.count = (table.values.shape[table.axis] for table in (source, target))
            values = target.values.capacity // 4
            rows = target.values.shape[0] if target.axis == 1 else 1
            handover.along, handover.begin = values // (handover.count * rows), self._size
            handovers.append(handover)
            self._size += values
        self._handovers = wp.array(handovers, dtype=Handover, device=device)

    def run(self) -> None:
        """Fill the targets."""
        launch(carry_kernel, self._size, [self._handovers], self.device)

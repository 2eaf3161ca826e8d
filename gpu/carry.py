"""What SP clusters know, handed on to another number of them: so a walk goes on where its counts change.

As many stay as there is room for, evenly many of them where there is less; the others are free. Beyond the 2022 paper,
whose future work are counts that are chosen for a wanted time.
"""

import warp as wp

from gpu.device import launch


@wp.func
def origin_of(cluster: int, count: int, before: int) -> int:
    """Which of the `before` clusters becomes this one of `count`, −1 for none."""
    if count >= before:
        return wp.where(cluster < before, cluster, -1)
    return int(wp.int64(cluster) * wp.int64(before) / wp.int64(count))


@wp.kernel
def carry_kernel(first: int, count: int, before: int, along: int, source: wp.array[wp.uint32],
                 target: wp.array[wp.uint32]) -> None:  # fmt: skip
    """One thread a value: that of the cluster where it comes from, 0 for a free one.

    Tables of `count` and `before` clusters, flattened: `along` values of each cluster lie side by side in every row.
    """
    index = first + wp.tid()
    row = index // (count * along)
    origin = origin_of((index // along) % count, count, before)
    value = wp.uint32(0)
    if origin >= 0:
        value = source[(row * before + origin) * along + index % along]
    target[index] = value


def carry(source: wp.array, target: wp.array, *, axis: int = 0) -> None:
    """Fill `target` with what `source` knows of clusters, the `axis` of both; values are one or more of four bytes."""
    words = [wp.array(ptr=table.ptr, dtype=wp.uint32, shape=table.capacity // 4, device=table.device)
             for table in (source, target)]  # fmt: skip
    count, before = target.shape[axis], source.shape[axis]
    rows = target.shape[0] if axis == 1 else 1
    launch(carry_kernel, words[1].size, [count, before, words[1].size // (count * rows), *words], target.device)

"""Sorting items into many small buckets, in a third of the time of a radix sort.

An item's place is found by comparing it with all others of its bucket, so the work grows with the square of a bucket's
size. Where buckets may be large, use gpu.core.radix_sort.
"""

import warp as wp
from warp.utils import array_scan

from gpu.core.device import launch, launch_together


@wp.kernel
def count_in_buckets_kernel(
    first: int, keys: wp.array[int], shift: int, counts: wp.array[int], slots: wp.array[int]
) -> None:
    """One thread an item: how many of its bucket came before it, slots (item,), by its key, keys (item,).

    counts (bucket + 1,): becomes how many there are, 0 before.
    """
    item = first + wp.tid()
    bucket = keys[item] >> shift
    if bucket < counts.shape[0] - 1:
        slots[item] = wp.atomic_add(counts, bucket, 1)


@wp.kernel
def place_in_buckets_kernel(first: int, keys: wp.array[int], shift: int, starts: wp.array[int], slots: wp.array[int],
                            placed: wp.array[wp.vec2i]) -> None:  # fmt: skip
    """One thread an item: puts (key, item) into its bucket, in no order: placed (place,).

    keys, slots (item,): as for `count_in_buckets_kernel`; starts (bucket + 1,): the first place of each.
    """
    item = first + wp.tid()
    key = keys[item]
    bucket = key >> shift
    if bucket < starts.shape[0] - 1:
        placed[starts[bucket] + slots[item]] = wp.vec2i(key, item)


@wp.kernel
def rank_in_buckets_kernel(first: int, shift: int, starts: wp.array[int], placed: wp.array[wp.vec2i],
                           items: wp.array[int]) -> None:  # fmt: skip
    """One thread a place: how many items of the bucket that is there come before the one that is, which goes there.

    starts, placed: as `place_in_buckets_kernel` left them; items (place,): sorted by key, then number.
    """
    place = first + wp.tid()
    if place >= starts[starts.shape[0] - 1]:
        return
    own = placed[place]
    bucket = own[0] >> shift
    begin = starts[bucket]
    rank = int(0)
    for other_place in range(begin, starts[bucket + 1]):
        other = placed[other_place]
        if other[0] < own[0] or (other[0] == own[0] and other[1] < own[1]):
            rank += 1
    items[begin + rank] = own[1]


class Buckets:
    """Items by key; after `sort`, those of bucket b are items[starts[b] : starts[b + 1]], sorted by key, then number.

    A bucket has 2^`shift` keys in a row. keys (capacity,), which are not negative, is written by the caller; items with
    a key beyond those of the `count` buckets belong to none, and starts[count] is how many are before them.
    """

    def __init__(self, capacity: int, count: int, device: wp.Device, *, shift: int = 0) -> None:
        self.capacity, self.device, self._shift = capacity, device, shift
        self.keys = wp.zeros(capacity, dtype=int, device=device)
        self.items = wp.zeros(capacity, dtype=int, device=device)
        self.starts = wp.zeros(count + 1, dtype=int, device=device)
        self._counts = wp.zeros(count + 1, dtype=int, device=device)
        self._slots = wp.zeros(capacity, dtype=int, device=device)
        self._placed = wp.zeros(capacity, dtype=wp.vec2i, device=device)

    def sort(self) -> None:
        """Sort the items by `keys`, to the same result on every device."""
        capacity, keys, shift, device = self.capacity, self.keys, self._shift, self.device
        self._counts.zero_()
        launch_together(count_in_buckets_kernel, capacity, [keys, shift, self._counts, self._slots], device)
        array_scan(self._counts, self.starts, inclusive=False)
        launch(place_in_buckets_kernel, capacity, [keys, shift, self.starts, self._slots, self._placed], device)
        launch(rank_in_buckets_kernel, capacity, [shift, self.starts, self._placed, self.items], device)

"""Sorting items by key on the device, so that each key's items lie together.

Few keys with few items each are sorted faster by gpu.core.bucket_sort.
"""

import warp as wp
from warp.utils import array_scan, radix_sort_pairs

from gpu.core.device import launch


@wp.kernel
def iota_kernel(first: int, values: wp.array[int]) -> None:
    """One thread an item: its own index."""
    index = first + wp.tid()
    values[index] = index


@wp.kernel
def keys_in_order_kernel(first: int, keys: wp.array[int], items: wp.array[int], ordered: wp.array[int]) -> None:
    """One thread a place: the key of the item that is there; keys (item,), items, ordered (place,)."""
    place = first + wp.tid()
    ordered[place] = keys[items[place]]


@wp.kernel
def group_starts_kernel(
    first: int, sorted_keys: wp.array[int], count: int, key_count: int, starts: wp.array[int]
) -> None:
    """One thread an item, one more at the end: writes the starts of all keys between its predecessor's and its own.

    sorted_keys (item,); starts (key + 1,).
    """
    index = first + wp.tid()
    previous = int(-1)
    if index > 0:
        previous = sorted_keys[index - 1]
    current = key_count
    if index < count:
        current = sorted_keys[index]
    for key in range(previous + 1, current + 1):
        starts[key] = index


class Groups:
    """Items grouped by an integer key; after `sort`, key k's items are items[starts[k] : starts[k + 1]], ascending, or
    in the order that it is given.

    keys (2·capacity,), up to `key_count`, is written by the caller; items with that key belong to no group.
    """

    def __init__(self, capacity: int, key_count: int, device: wp.Device) -> None:
        self.capacity, self.key_count, self.device = capacity, key_count, device
        self.keys = wp.zeros(2 * capacity, dtype=int, device=device)
        self.items = wp.zeros(2 * capacity, dtype=int, device=device)
        self.starts = wp.zeros(key_count + 1, dtype=int, device=device)

    def sort(self, order: wp.array | None = None) -> None:
        """Group the `capacity` items by `keys`; the order within a group is that of the items, on every device.

        order (capacity,): all items, as those of a group are to follow each other.
        """
        if order is None:
            launch(iota_kernel, self.capacity, [self.items], self.device)
        else:
            wp.copy(self.items, order, count=self.capacity)
            ordered = self.keys[self.capacity :]
            launch(keys_in_order_kernel, self.capacity, [self.keys, self.items, ordered], self.device)
            wp.copy(self.keys, ordered, count=self.capacity)
        radix_sort_pairs(self.keys, self.items, self.capacity, end_bit=self.key_count.bit_length())
        inputs = [self.keys, self.capacity, self.key_count, self.starts]
        launch(group_starts_kernel, self.capacity + 1, inputs, self.device)


def running_total(values: wp.array, totals: wp.array) -> None:
    """Inclusive prefix sums of the int array `values` into `totals`."""
    array_scan(values, totals, inclusive=True)

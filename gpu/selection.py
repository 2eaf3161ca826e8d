"""Some of the shading points of a list, chosen by keys, in the list's order."""

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.device import launch
from gpu.grouping import iota_kernel
from gpu.shading_points import ListedPoints

# Keys are 8 bits, so that one pass sorts them; LAST is that of a point that is not chosen.
KEY_BITS = 8
LAST = wp.constant(255)
NOWHERE = wp.constant(0x7FFFFFFF)


@wp.kernel
def select_kernel(first: int, keys: wp.array[int], order: wp.array[int], end: int, selected: wp.array[int],
                  count: wp.array[int]) -> None:  # fmt: skip
    """One thread a place in the list of the chosen: their places in the list of all, up to the first of key `end`."""
    place = first + wp.tid()
    selected[place] = NOWHERE
    if keys[place] >= end:
        return
    selected[place] = order[place]
    if 2 * place == selected.shape[0] - 2 or keys[place + 1] >= end:
        count[0] = place + 1


@wp.kernel
def list_kernel(first: int, pixels: wp.array[int], numbers: wp.array[int], selected: wp.array[int],
                count: wp.array[int], to_pixels: wp.array[int], to_numbers: wp.array[int]) -> None:  # fmt: skip
    """One thread a chosen SP, now sorted as the SPs are, so that neighbours' rays run together: which it is."""
    place = first + wp.tid()
    if place < count[0]:
        to_pixels[place] = pixels[selected[place]]
        to_numbers[place] = numbers[selected[place]]


class Selection:
    """Of up to `among` SPs the at most `capacity` of the smallest `keys` (place,): ListedPoints.

    end: the key from which on none is chosen, up to LAST.
    """

    def __init__(self, among: int, capacity: int, end: int, device: wp.Device) -> None:
        self.device, self._end = device, end
        self.capacity = min(capacity, among)
        self.keys = wp.zeros(2 * among, dtype=int, device=device)
        self._order = wp.zeros(2 * among, dtype=int, device=device)
        self._selected = wp.zeros(2 * self.capacity, dtype=int, device=device)
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.numbers = wp.zeros(self.capacity, dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)

    def choose(self, points: ListedPoints) -> None:
        """List those of `points`, whose keys are set; LAST for places beyond their count."""
        device = self.device
        launch(iota_kernel, points.capacity, [self._order], device)
        radix_sort_pairs(self.keys, self._order, points.capacity, 0, KEY_BITS)
        self.count.zero_()
        launch(select_kernel, self.capacity, [self.keys, self._order, self._end, self._selected, self.count], device)
        radix_sort_pairs(self._selected, self._order, self.capacity)
        inputs = [points.pixels, points.numbers, self._selected, self.count, self.pixels, self.numbers]
        launch(list_kernel, self.capacity, inputs, device)

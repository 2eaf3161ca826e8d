"""Some of the shading points of a list, chosen by keys, in the list's order."""

import warp as wp
from warp.utils import array_scan

from gpu.core.device import launch, launch_together
from gpu.core.intrinsics import count_in
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints

# Keys are below this, and LAST is that of a point that is not chosen.
KEY_COUNT = 256
LAST = wp.constant(KEY_COUNT - 1)
# Marks of those that are chosen, and of those of the key of which only the first are: running totals count both.
CHOSEN_SHIFT = wp.constant(wp.int64(32))
CHOSEN, TIED = wp.constant(wp.int64(1 << 32)), wp.constant(wp.int64(1))


@wp.kernel
def top_k_count_kernel(first: int, keys: wp.array[int], end: int, counts: wp.array[int]) -> None:
    """One thread a listed SP: counts (key,) how many there are of each key below `end`; keys (place,)."""
    key = keys[first + wp.tid()]
    if key < end:
        count_in(counts, key)


@wp.kernel
def top_k_mark_kernel(first: int, keys: wp.array[int], end: int, totals: wp.array[int], most: wp.array[int],
                marks: wp.array[wp.int64]) -> None:  # fmt: skip
    """One thread a listed SP: CHOSEN where all up to its key are at most `most` (1,), TIED where but some of it are.

    keys, marks (place,); totals (key,): how many there are up to each.
    """
    place = first + wp.tid()
    key = keys[place]
    marks[place] = wp.int64(0)
    if key >= end:
        return
    if totals[key] <= most[0]:
        marks[place] = CHOSEN
    elif key == 0 or totals[key - 1] < most[0]:
        marks[place] = TIED


@wp.func
def listed_before(total: wp.int64, most_tied: int) -> int:
    """How many are listed of those that a running total of marks counts, of the tied ones at most so many."""
    return int(total >> CHOSEN_SHIFT) + wp.min(int(total & (CHOSEN - TIED)), most_tied)


@wp.kernel
def top_k_list_kernel(first: int, points: PointList, totals: wp.array[wp.int64], last: int, most: wp.array[int],
                      chosen: PointList) -> None:  # fmt: skip
    """One thread a listed SP: lists it among the chosen if it is one; totals (place,): of marks, with its own.

    last: the place whose totals are of all; most (1,): how many are listed at most.
    """
    place = first + wp.tid()
    most_tied = most[0] - int(totals[last] >> CHOSEN_SHIFT)
    end = listed_before(totals[place], most_tied)
    begin = int(0)
    if place > 0:
        begin = listed_before(totals[place - 1], most_tied)
    if begin < end:
        chosen.pixels[begin] = points.pixels[place]
        chosen.numbers[begin] = points.numbers[place]
    if place == last:
        chosen.count[0] = end


class Selection:
    """Of `among` places for SPs the at most `capacity` of the smallest `keys` (place,), first ones first: ListedPoints.

    end: the key from which on none is chosen, up to LAST. It chooses as many as there is room for until `limit` says
    otherwise.
    """

    def __init__(self, among: int, capacity: int, end: int, device: wp.Device) -> None:
        self.device, self._end = device, end
        self.capacity = min(capacity, among)
        self._most = wp.full(1, self.capacity, dtype=int, device=device)
        self.keys = wp.zeros(among, dtype=int, device=device)
        self._counts = wp.zeros(KEY_COUNT, dtype=int, device=device)
        self._marks = wp.zeros(among, dtype=wp.int64, device=device)
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.numbers = wp.zeros(self.capacity, dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)
        self.points = PointList()
        self.points.pixels, self.points.numbers, self.points.count = self.pixels, self.numbers, self.count

    def limit(self, most: int) -> None:
        """Choose at most so many, and no more than there is room for."""
        self._most.fill_(min(most, self.capacity))

    def choose(self, points: ListedPoints) -> None:
        """List those of all `points`, whose keys are set; LAST for places beyond their count."""
        among, device, most, counts, marks = len(self.keys), self.device, self._most, self._counts, self._marks
        counts.zero_()
        launch_together(top_k_count_kernel, among, [self.keys, self._end, counts], device)
        array_scan(counts, counts)
        launch(top_k_mark_kernel, among, [self.keys, self._end, counts, most, marks], device)
        array_scan(marks, marks)
        launch(top_k_list_kernel, among, [points.points, marks, among - 1, most, self.points], device)

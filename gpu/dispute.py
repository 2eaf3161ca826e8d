"""Which shading points fuzzy clusters serve worst. Beyond the 2022 paper.

Averaging the visibility of F representatives goes wrong at few pixels, but far: behind slats, in cracks, at contacts,
where one percent of the pixels hold nine tenths of the relative error. Two things tell them. Dispute: how much brighter
an SP would be if one of its clusters were right alone than if another were. Surprise: rays from the SP itself, towards
light that its clusters see, are stopped (gpu.check).
"""

import math

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.counting import PARTIALS
from gpu.device import launch
from gpu.grouping import iota_kernel
from gpu.shade import Indirect
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import UNSERVED_NEED

# Keys are 8 bits, so that one pass sorts them; 0 is an SP without a cluster, SETTLED one that is not worth a ray.
KEY_BITS = 8
SETTLED = wp.constant(255)
STEPS_PER_OCTAVE = wp.constant(12.0)
WORST_OCTAVE = wp.constant(12.0)
# Of the mean picture's brightness: darker than that is as good as black to the eye and to relMSE.
DARK = wp.constant(0.1)
# Neighbours in the list of SPs, a square of pixels, share what their rays found.
BLOCK = wp.constant(16)
SETTLED_SP = wp.constant(0x7FFFFFFF)


@wp.kernel
def brightness_kernel(first: int, sp_count: wp.array[int], indirect: Indirect, partials: wp.array[float]) -> None:
    """One thread a partial sum over every PARTIALS-th SP of its brightness."""
    partial = first + wp.tid()
    total = float(0.0)
    sp = int(partial)
    while sp < sp_count[0]:
        total += 0.5 * (indirect.low[sp] + indirect.high[sp])
        sp += PARTIALS
    partials[partial] = total


@wp.kernel
def mean_kernel(first: int, sp_count: wp.array[int], partials: wp.array[float], mean: wp.array[float]) -> None:
    """One thread: the mean brightness of all SPs."""
    _single = first + wp.tid()
    total = float(0.0)
    for partial in range(PARTIALS):
        total += partials[partial]
    mean[0] = total / float(wp.max(sp_count[0], 1))


@wp.kernel
def dispute_kernel(first: int, sp_count: wp.array[int], need: wp.array[int], indirect: Indirect,
                   stopped: wp.array[float], mean: wp.array[float], keys: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: by how much it may be too bright, relative to how dark it may be, as a key; worst first.

    need (sp,): UNSERVED_NEED marks SPs without a cluster, which come before all others.
    """
    sp = first + wp.tid()
    keys[sp] = SETTLED
    if sp >= sp_count[0]:
        return
    if need[sp] >= UNSERVED_NEED:
        keys[sp] = 0
        return
    nearby = float(0.0)
    begin = (sp // BLOCK) * BLOCK
    for neighbour in range(begin, wp.min(begin + BLOCK, sp_count[0])):
        nearby += stopped[neighbour]
    lost = wp.max(nearby / float(BLOCK), stopped[sp])
    high = indirect.high[sp]
    low = wp.min(indirect.low[sp], high * (1.0 - lost))
    ratio = (high - low) / (low + DARK * mean[0] + 1.0e-30)
    if ratio > 0.0:
        keys[sp] = wp.clamp(int(STEPS_PER_OCTAVE * (WORST_OCTAVE - wp.log2(ratio))), 1, SETTLED)


@wp.kernel
def select_kernel(first: int, keys: wp.array[int], order: wp.array[int], settled: int, selected: wp.array[int],
                  count: wp.array[int]) -> None:  # fmt: skip
    """One thread a place in the list of the worst SPs: which they are, up to the first that is good enough."""
    place = first + wp.tid()
    selected[place] = SETTLED_SP
    if keys[place] >= settled:
        return
    selected[place] = order[place]
    if 2 * place == selected.shape[0] - 2 or keys[place + 1] >= settled:
        count[0] = place + 1


@wp.kernel
def selected_pixel_kernel(first: int, sps: wp.array[int], selected: wp.array[int], count: wp.array[int],
                          pixels: wp.array[int]) -> None:  # fmt: skip
    """One thread a selected SP, now sorted as the SPs are, so that neighbours' rays run together: its pixel."""
    place = first + wp.tid()
    if place < count[0]:
        pixels[place] = sps[selected[place]]


class WorstPoints:
    """Finds the at most `capacity` SPs that are most likely far too bright: `pixels` (place,), of which `count` (1,).

    least: what may be too bright, relative to how dark the SP may be, below which it is left as it is.
    """

    def __init__(self, pixels: int, capacity: int, least: float, device: wp.Device) -> None:
        self.device = device
        self._settled = int(float(STEPS_PER_OCTAVE) * (float(WORST_OCTAVE) - math.log2(least)))
        capacity = min(capacity, pixels)
        self._keys = wp.zeros(2 * pixels, dtype=int, device=device)
        self._order = wp.zeros(2 * pixels, dtype=int, device=device)
        self._partials = wp.zeros(PARTIALS, dtype=float, device=device)
        self._mean = wp.zeros(1, dtype=float, device=device)
        self._selected = wp.zeros(2 * capacity, dtype=int, device=device)
        self.pixels = wp.zeros(capacity, dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)

    def find(self, sps: ShadingPoints, need: wp.array, indirect: Indirect, stopped: wp.array) -> None:
        """List the worst of `sps`; need, stopped (sp,): of gpu.sp_clusters and gpu.check."""
        device = self.device
        launch(brightness_kernel, PARTIALS, [sps.count, indirect, self._partials], device)
        launch(mean_kernel, 1, [sps.count, self._partials, self._mean], device)
        inputs = [sps.count, need, indirect, stopped, self._mean, self._keys]
        launch(dispute_kernel, sps.capacity, inputs, device)
        launch(iota_kernel, sps.capacity, [self._order], device)
        radix_sort_pairs(self._keys, self._order, sps.capacity, 0, KEY_BITS)
        self.count.zero_()
        capacity = len(self.pixels)
        inputs = [self._keys, self._order, self._settled, self._selected, self.count]
        launch(select_kernel, capacity, inputs, device)
        radix_sort_pairs(self._selected, self._order, capacity)
        inputs = [sps.pixels, self._selected, self.count, self.pixels]
        launch(selected_pixel_kernel, capacity, inputs, device)

"""Exact visibility for the shading points that fuzzy clusters serve worst. Beyond the 2022 paper.

Averaging the visibility of F representatives goes wrong at few pixels, but far: behind slats, in cracks, at contacts,
where one percent of the pixels hold nine tenths of the relative error. They can be told by their clusters' dispute: how
much brighter the SP would be if one of its clusters were right alone than if another were. The most disputed SPs become
representatives of themselves.
"""

import math

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.counting import PARTIALS
from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.grouping import iota_kernel
from gpu.resident import SceneData
from gpu.shade import Indirect, allocate_indirect, shade
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters, allocate_sp_clusters
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# Keys are 8 bits, so that one pass sorts them; 0 is the worst dispute, SETTLED none worth a ray.
KEY_BITS = 8
SETTLED = wp.constant(255)
STEPS_PER_OCTAVE = wp.constant(8.0)
WORST_OCTAVE = wp.constant(12.0)
# Of the mean picture's brightness: darker than that is as good as black to the eye and to relMSE.
DARK = wp.constant(0.1)


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
def dispute_kernel(first: int, sp_count: wp.array[int], indirect: Indirect, mean: wp.array[float],
                   keys: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: how far its clusters are apart, relative to the darker of them, as a key; worst first."""
    sp = first + wp.tid()
    keys[sp] = SETTLED
    if sp >= sp_count[0]:
        return
    low = indirect.low[sp]
    ratio = (indirect.high[sp] - low) / (low + DARK * mean[0] + 1.0e-30)
    if ratio > 0.0:
        keys[sp] = wp.clamp(int(STEPS_PER_OCTAVE * (WORST_OCTAVE - wp.log2(ratio))), 0, SETTLED)


@wp.kernel
def select_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], keys: wp.array[int], order: wp.array[int],
                  least: int, pixels: wp.array[int], count: wp.array[int], out: SpClusters) -> None:  # fmt: skip
    """One thread a place in the list of the worst: makes its SP a representative of itself."""
    place = first + wp.tid()
    out.used[place] = 0
    out.cluster[0, place] = place
    out.weight[0, place] = 1.0
    if keys[place] >= least:
        return
    pixel = sps[order[place]]
    pixels[place] = pixel
    out.used[place] = 1
    out.position[place] = gbuffer.position[pixel]
    out.geometric[place] = gbuffer.geometric[pixel]
    if place == pixels.shape[0] - 1 or keys[place + 1] >= least:
        count[0] = place + 1


class Refinement:
    """Re-shades the at most `capacity` most disputed SPs with visibility of their own; arrays are allocated once.

    `count` (1,): how many the last frame refined. least: dispute below which an SP is left as it is, the ratio of what
    its clusters differ by to the darker of them.
    """

    def __init__(self, pixels: int, capacity: int, vpl_count: int, least: float, device: wp.Device) -> None:
        self.device = device
        self._least = int(float(STEPS_PER_OCTAVE) * (float(WORST_OCTAVE) - math.log2(least)))
        capacity = min(capacity, pixels)
        self._keys = wp.zeros(2 * pixels, dtype=int, device=device)
        self._order = wp.zeros(2 * pixels, dtype=int, device=device)
        self._partials = wp.zeros(PARTIALS, dtype=float, device=device)
        self._mean = wp.zeros(1, dtype=float, device=device)
        self._pixels = wp.zeros(capacity, dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)
        self._selected = allocate_sp_clusters(capacity, 1, capacity, device)
        self.visibility = Visibility(capacity, vpl_count, device)
        self._range = allocate_indirect(capacity, device)

    def run(
        self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, indirect: Indirect
    ) -> None:
        """Overwrite `indirect.radiance` of the most disputed of `sps`."""
        device = self.device
        launch(brightness_kernel, PARTIALS, [sps.count, indirect, self._partials], device)
        launch(mean_kernel, 1, [sps.count, self._partials, self._mean], device)
        launch(dispute_kernel, sps.capacity, [sps.count, indirect, self._mean, self._keys], device)
        launch(iota_kernel, sps.capacity, [self._order], device)
        radix_sort_pairs(self._keys, self._order, sps.capacity, 0, KEY_BITS)
        self.count.zero_()
        inputs = [gbuffer, sps.pixels, self._keys, self._order, self._least, self._pixels, self.count, self._selected]
        launch(select_kernel, len(self._pixels), inputs, device)
        self.visibility.trace(scene, self._selected, vpls)
        # The range of one cluster is of no use, and must not overwrite that of the SPs it was made from.
        self._range.radiance = indirect.radiance
        shade(1, gbuffer, self._pixels, self.count, self._selected, self.visibility, vpls, self._range)

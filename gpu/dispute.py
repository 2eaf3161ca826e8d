"""Which shading points neighbours must not speak for. Beyond the 2022 paper.

What rays correct is shared between neighbours on a surface. That is wrong at few pixels, but far: in cracks, behind
slats, at contacts, where one percent of the pixels hold nine tenths of the relative error. There an SP's own rays find
it much darker than what it shares. Few rays often do so by chance, too: in a conference room one of 47 such SPs is that
dark. So suspects get as many rays again, and those that remain get many (gpu.refine).
"""

import math

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.device import launch
from gpu.gbuffer import GBuffer, reflectance
from gpu.grouping import iota_kernel
from gpu.new_clusters import UNSERVED_NEED
from gpu.shading_points import ListedPoints, ShadingPoints
from gpu.transfer import brightness

# Keys are 8 bits, so that one pass sorts them; 0 is an SP without a cluster, SETTLED one that is not worth a ray.
KEY_BITS = 8
SETTLED = wp.constant(255)
STEPS_PER_OCTAVE = wp.constant(12.0)
WORST_OCTAVE = wp.constant(12.0)
# SPs whose brightness stands for that of the picture.
SAMPLES = wp.constant(1024)
# Of the mean picture's brightness: darker than that is as good as black to the eye and to relMSE.
DARK = wp.constant(0.1)
NOWHERE = wp.constant(0x7FFFFFFF)


@wp.kernel
def brightness_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], sp_count: wp.array[int],
                      irradiance: wp.array[wp.vec3], samples: wp.array[float]) -> None:  # fmt: skip
    """One thread a sample: the brightness of the first SP of each of SAMPLES equal runs of the list."""
    sample = first + wp.tid()
    samples[sample] = 0.0
    if sp_count[0] > 0:
        pixel = sps[int(wp.int64(sample) * wp.int64(sp_count[0]) / wp.int64(SAMPLES))]
        samples[sample] = brightness(wp.cw_mul(reflectance(gbuffer, pixel), irradiance[pixel]))


@wp.kernel
def mean_kernel(first: int, samples: wp.array[float], mean: wp.array[float]) -> None:
    """One thread: the mean of the samples."""
    _single = first + wp.tid()
    total = float(0.0)
    for sample in range(SAMPLES):
        total += samples[sample]
    mean[0] = total / float(SAMPLES)


@wp.kernel
def dispute_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], numbers: wp.array[int], count: wp.array[int],
                   need: wp.array[int], irradiance: wp.array[wp.vec3], own: wp.array[wp.vec3],
                   shared: wp.array[wp.vec3], mean: wp.array[float], keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a listed SP: by how much it may be too bright, relative to how dark it may be, as a key; worst first.

    need (sp,): UNSERVED_NEED marks SPs without a cluster, which come before all others; own, shared (pixel,): what
    corrects the `irradiance` (pixel,) by the SP's rays alone, and with its neighbours'.
    """
    place = first + wp.tid()
    keys[place] = SETTLED
    if place >= count[0]:
        return
    if need[numbers[place]] >= UNSERVED_NEED:
        keys[place] = 0
        return
    pixel = pixels[place]
    reflected = reflectance(gbuffer, pixel)
    high = brightness(wp.cw_mul(reflected, irradiance[pixel] + shared[pixel]))
    low = wp.max(brightness(wp.cw_mul(reflected, irradiance[pixel] + own[pixel])), 0.0)
    ratio = (high - low) / (low + DARK * mean[0] + 1.0e-30)
    if ratio > 0.0:
        keys[place] = wp.clamp(int(STEPS_PER_OCTAVE * (WORST_OCTAVE - wp.log2(ratio))), 1, SETTLED)


@wp.kernel
def select_kernel(first: int, keys: wp.array[int], order: wp.array[int], settled: int, selected: wp.array[int],
                  count: wp.array[int]) -> None:  # fmt: skip
    """One thread a place in the list of the worst: their places in the list of all, up to the first good enough."""
    place = first + wp.tid()
    selected[place] = NOWHERE
    if keys[place] >= settled:
        return
    selected[place] = order[place]
    if 2 * place == selected.shape[0] - 2 or keys[place + 1] >= settled:
        count[0] = place + 1


@wp.kernel
def list_kernel(first: int, pixels: wp.array[int], numbers: wp.array[int], selected: wp.array[int],
                count: wp.array[int], to_pixels: wp.array[int], to_numbers: wp.array[int]) -> None:  # fmt: skip
    """One thread a selected SP, now sorted as the SPs are, so that neighbours' rays run together: which it is."""
    place = first + wp.tid()
    if place < count[0]:
        to_pixels[place] = pixels[selected[place]]
        to_numbers[place] = numbers[selected[place]]


class MeanBrightness:
    """About how bright a picture is: `value` (1,) [W/m²/sr]."""

    def __init__(self, device: wp.Device) -> None:
        self.device = device
        self._samples = wp.zeros(SAMPLES, dtype=float, device=device)
        self.value = wp.zeros(1, dtype=float, device=device)

    def find(self, gbuffer: GBuffer, sps: ShadingPoints, irradiance: wp.array) -> None:
        """Measure it by some of all `sps`; irradiance (pixel,)."""
        inputs = [gbuffer, sps.pixels, sps.count, irradiance, self._samples]
        launch(brightness_kernel, SAMPLES, inputs, self.device)
        launch(mean_kernel, 1, [self._samples, self.value], self.device)


class WorstPoints:
    """Of up to `among` SPs the at most `capacity` that are most likely far too bright: ListedPoints.

    least: what may be too bright, relative to how dark the SP may be, below which it is left as it is.
    """

    def __init__(self, among: int, capacity: int, least: float, device: wp.Device) -> None:
        self.device = device
        self.capacity = min(capacity, among)
        self._settled = int(float(STEPS_PER_OCTAVE) * (float(WORST_OCTAVE) - math.log2(least)))
        self._keys = wp.zeros(2 * among, dtype=int, device=device)
        self._order = wp.zeros(2 * among, dtype=int, device=device)
        self._selected = wp.zeros(2 * self.capacity, dtype=int, device=device)
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.numbers = wp.zeros(self.capacity, dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)

    def find(self, points: ListedPoints, gbuffer: GBuffer, need: wp.array, irradiance: wp.array, own: wp.array,
             shared: wp.array, mean: MeanBrightness) -> None:  # fmt: skip
        """List the worst of `points`, as `dispute_kernel` tells."""
        device, listed = self.device, [points.pixels, points.numbers]
        inputs = [gbuffer, *listed, points.count, need, irradiance, own, shared, mean.value, self._keys]
        launch(dispute_kernel, points.capacity, inputs, device)
        launch(iota_kernel, points.capacity, [self._order], device)
        radix_sort_pairs(self._keys, self._order, points.capacity, 0, KEY_BITS)
        self.count.zero_()
        inputs = [self._keys, self._order, self._settled, self._selected, self.count]
        launch(select_kernel, self.capacity, inputs, device)
        radix_sort_pairs(self._selected, self._order, self.capacity)
        inputs = [*listed, self._selected, self.count, self.pixels, self.numbers]
        launch(list_kernel, self.capacity, inputs, device)

"""Rays of their own for the shading points that fuzzy clusters serve worst. Beyond the 2022 paper.

Averaging the visibility of F representatives goes wrong at few pixels, but far: behind slats, in cracks, at contacts,
where one percent of the pixels hold nine tenths of the relative error. Two things tell them. Dispute: how much brighter
an SP would be if one of its clusters were right alone than if another were. Surprise: rays from the SP itself, towards
light that its clusters see, are stopped. The worst SPs then get one ray for each 32 VPL clusters.
"""

import math
from functools import cache

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.counting import PARTIALS
from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.grouping import iota_kernel
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import CHECKS, Indirect, reflectance
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, unoccluded
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# Keys are 8 bits, so that one pass sorts them; 0 is the worst SP, SETTLED one that is not worth a ray.
KEY_BITS = 8
SETTLED = wp.constant(255)
STEPS_PER_OCTAVE = wp.constant(12.0)
WORST_OCTAVE = wp.constant(12.0)
# Of the mean picture's brightness: darker than that is as good as black to the eye and to relMSE.
DARK = wp.constant(0.1)
# Neighbours in the list of SPs, a square of pixels, share what their rays found.
BLOCK = wp.constant(16)
# Words of 32 VPL clusters that are traced at a time; bounds the memory of the answers.
WORDS_AT_ONCE = 64
SETTLED_SP = wp.constant(0x7FFFFFFF)
CHECK_KEY = wp.constant(wp.uint32(0x5BD1E995))


@wp.struct
class Pick:
    """One VPL cluster of a word, drawn in proportion to its light; `light` is the whole word's irradiance [W/m²].

    cluster is −1 when the word sends no light.
    """

    cluster: int
    light: wp.vec3


@wp.struct
class Target:
    """A VPL cluster to check, −1 for none, and the share of it that the SP's clusters see."""

    cluster: int
    share: float


@wp.func
def target_in(word: int, sp: int, position: wp.vec3, normal: wp.vec3, clusters: SpClusters,
              visibility: wp.array2d[wp.uint32], vpls: VplClusters, state: wp.uint32) -> Target:  # fmt: skip
    """A VPL cluster of `word`, drawn in proportion to the light that the SP is believed to get of it."""
    target = Target()
    target.cluster = -1
    total = float(0.0)
    for bit in range(32):
        share = float(0.0)
        for f in range(clusters.cluster.shape[0]):
            answer = (visibility[clusters.cluster[f, sp], word] >> wp.uint32(bit)) & wp.uint32(1)
            share += clusters.weight[f, sp] * float(answer)
        if share > 0.0:
            amount = share * brightness(unoccluded(position, normal, vpls, 32 * word + bit))
            total += amount
            state = hashed(state)
            if float(state) * TO_UNIT * total < amount:
                target.cluster = 32 * word + bit
                target.share = share
    return target


@cache
def check_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        sps: wp.array[int],
        sp_count: wp.array[int],
        clusters: SpClusters,
        visibility: wp.array2d[wp.uint32],
        vpls: VplClusters,
        indirect: Indirect,
        surprise: wp.array[float],
    ) -> None:
        """One thread an SP: a ray towards light that its clusters see, and CHECKS − 1 more if that is stopped.

        surprise (sp,): the share of the light checked that does not arrive, 0 where the first ray does.
        """
        sp = first + wp.tid()
        surprise[sp] = 0.0
        if sp >= sp_count[0]:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        geometric = gbuffer.geometric[pixel]
        state = hashed(wp.uint32(pixel) ^ CHECK_KEY)
        stopped = float(0.0)
        for check in range(CHECKS):
            state = hashed(state)
            word = indirect.word[check, sp]
            target = target_in(word, sp, position, normal, clusters, visibility, vpls, state)
            if target.cluster < 0:
                break
            if connect(scene, position, geometric, vpls.position[target.cluster], vpls.normal[target.cluster]):
                if check == 0:
                    break
            else:
                stopped += target.share
        surprise[sp] = stopped / float(CHECKS)

    return kernel


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
def dispute_kernel(first: int, sp_count: wp.array[int], indirect: Indirect, surprise: wp.array[float],
                   mean: wp.array[float], keys: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: by how much it may be too bright, relative to how dark it may be, as a key; worst first."""
    sp = first + wp.tid()
    keys[sp] = SETTLED
    if sp >= sp_count[0]:
        return
    stopped = float(0.0)
    begin = (sp // BLOCK) * BLOCK
    for neighbour in range(begin, wp.min(begin + BLOCK, sp_count[0])):
        stopped += surprise[neighbour]
    stopped = wp.max(stopped / float(BLOCK), surprise[sp])
    high = indirect.high[sp]
    low = wp.min(indirect.low[sp], high * (1.0 - stopped))
    ratio = (high - low) / (low + DARK * mean[0] + 1.0e-30)
    if ratio > 0.0:
        keys[sp] = wp.clamp(int(STEPS_PER_OCTAVE * (WORST_OCTAVE - wp.log2(ratio))), 0, SETTLED)


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


@wp.func
def pick_of_word(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, word: int, state: wp.uint32) -> Pick:
    """A VPL cluster of `word`, drawn in proportion to its unoccluded light at an SP."""
    pick = Pick()
    pick.cluster = -1
    total = float(0.0)
    for vpl in range(32 * word, wp.min(32 * word + 32, vpls.count)):
        light = unoccluded(position, normal, vpls, vpl)
        amount = brightness(light)
        if amount > 0.0:
            total += amount
            pick.light += light
            state = hashed(state)
            if float(state) * TO_UNIT * total < amount:
                pick.cluster = vpl
    return pick


@cache
def word_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        count: wp.array[int],
        vpls: VplClusters,
        first_word: int,
        light: wp.array[wp.vec3],
    ) -> None:
        """One thread a word of 32 VPL clusters at one SP: their light there, judged by a ray to one of them.

        light: (word − first_word, place), flattened [W/m²].
        """
        index = first + wp.tid()
        place = index % pixels.shape[0]
        word = first_word + index // pixels.shape[0]
        if place >= count[0]:
            return
        pixel = pixels[place]
        position = gbuffer.position[pixel]
        state = hashed(wp.uint32(pixel) ^ hashed(wp.uint32(word)))
        pick = pick_of_word(position, gbuffer.normal[pixel], vpls, word, state)
        light[index] = wp.vec3(0.0, 0.0, 0.0)
        if pick.cluster >= 0:
            target = vpls.position[pick.cluster]
            if connect(scene, position, gbuffer.geometric[pixel], target, vpls.normal[pick.cluster]):
                light[index] = pick.light

    return kernel


@wp.kernel
def sum_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int], light: wp.array[wp.vec3],
               words: int, anew: bool, radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a refined SP: adds what `words` words sent to its radiance, which starts `anew` with the first."""
    place = first + wp.tid()
    if place >= count[0]:
        return
    total = wp.vec3(0.0, 0.0, 0.0)
    for word in range(words):
        total += light[word * pixels.shape[0] + place]
    pixel = pixels[place]
    reflected = wp.cw_mul(reflectance(gbuffer, pixel), total)
    if not anew:
        reflected += radiance[pixel]
    radiance[pixel] = reflected


class Refinement:
    """Re-shades the at most `capacity` worst SPs with rays of their own; arrays are allocated once.

    `count` (1,): how many the last frame refined. least: what may be too bright, relative to how dark the SP may be,
    below which it is left as it is.
    """

    def __init__(self, pixels: int, capacity: int, least: float, device: wp.Device) -> None:
        self.device = device
        self._settled = int(float(STEPS_PER_OCTAVE) * (float(WORST_OCTAVE) - math.log2(least)))
        capacity = min(capacity, pixels)
        self._surprise = wp.zeros(pixels, dtype=float, device=device)
        self._keys = wp.zeros(2 * pixels, dtype=int, device=device)
        self._order = wp.zeros(2 * pixels, dtype=int, device=device)
        self._partials = wp.zeros(PARTIALS, dtype=float, device=device)
        self._mean = wp.zeros(1, dtype=float, device=device)
        self._selected = wp.zeros(2 * capacity, dtype=int, device=device)
        self._pixels = wp.zeros(capacity, dtype=int, device=device)
        self._light = wp.zeros(capacity * WORDS_AT_ONCE, dtype=wp.vec3, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)

    def select(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters,
               visibility: Visibility, vpls: VplClusters, indirect: Indirect) -> None:  # fmt: skip
        """Find the SPs of `indirect` that are most likely far too bright."""
        device = self.device
        inputs = [scene, gbuffer, sps.pixels, sps.count, clusters, visibility.words, vpls, indirect, self._surprise]
        launch(check_kernel(connection(scene)), sps.capacity, inputs, device)
        launch(brightness_kernel, PARTIALS, [sps.count, indirect, self._partials], device)
        launch(mean_kernel, 1, [sps.count, self._partials, self._mean], device)
        launch(dispute_kernel, sps.capacity, [sps.count, indirect, self._surprise, self._mean, self._keys], device)
        launch(iota_kernel, sps.capacity, [self._order], device)
        radix_sort_pairs(self._keys, self._order, sps.capacity, 0, KEY_BITS)
        self.count.zero_()
        inputs = [self._keys, self._order, self._settled, self._selected, self.count]
        capacity = len(self._pixels)
        launch(select_kernel, capacity, inputs, device)
        radix_sort_pairs(self._selected, self._order, capacity)
        inputs = [sps.pixels, self._selected, self.count, self._pixels]
        launch(selected_pixel_kernel, capacity, inputs, device)

    def trace(self, scene: SceneData, gbuffer: GBuffer, vpls: VplClusters, indirect: Indirect) -> None:
        """Overwrite the selected SPs' indirect radiance by what rays of their own say."""
        words, capacity = -(-vpls.count // 32), len(self._pixels)
        for first_word in range(0, words, WORDS_AT_ONCE):
            run = min(WORDS_AT_ONCE, words - first_word)
            inputs = [scene, gbuffer, self._pixels, self.count, vpls, first_word, self._light]
            launch(word_kernel(connection(scene)), run * capacity, inputs, self.device)
            inputs = [gbuffer, self._pixels, self.count, self._light, run, first_word == 0, indirect.radiance]
            launch(sum_kernel, capacity, inputs, self.device)

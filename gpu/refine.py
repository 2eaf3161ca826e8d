"""Rays of their own for the shading points that fuzzy clusters serve worst. Beyond the 2022 paper.

Averaging the visibility of F representatives goes wrong at few pixels, but far: behind slats, in cracks, at contacts,
where one percent of the pixels hold nine tenths of the relative error. Two things tell them. Dispute: how much brighter
an SP would be if one of its clusters were right alone than if another were. Surprise: rays from the SP itself, towards
light that its clusters see, are stopped. The worst SPs then get one ray for each 32 VPL clusters.
"""

import math
from functools import cache
from typing import Any

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.counting import PARTIALS
from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.grouping import iota_kernel, running_total
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import CHECKS, Indirect, reflectance
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import UNSERVED_NEED, SpClusters
from gpu.transfer import brightness, unoccluded
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# Keys are 8 bits, so that one pass sorts them; 0 is an SP without a cluster, SETTLED one that is not worth a ray.
KEY_BITS = 8
SETTLED = wp.constant(255)
STEPS_PER_OCTAVE = wp.constant(12.0)
WORST_OCTAVE = wp.constant(12.0)
# Of the mean picture's brightness: darker than that is as good as black to the eye and to relMSE.
DARK = wp.constant(0.1)
# Neighbours in the list of SPs, a square of pixels, share what their rays found.
BLOCK = wp.constant(16)
# Of all SPs, at most this share has its stopped first ray confirmed by others.
CONFIRMED_SHARE = 0.2
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


@wp.func
def target_in(word: int, sp: int, position: wp.vec3, normal: wp.vec3, clusters: SpClusters,
              visibility: wp.array2d[wp.uint32], vpls: VplClusters, state: wp.uint32) -> int:  # fmt: skip
    """A VPL cluster of `word`, drawn in proportion to the light that the SP is believed to get of it, or −1."""
    target = int(-1)
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
                target = 32 * word + bit
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
        listed: wp.array[int],
        count: wp.array[int],
        clusters: SpClusters,
        visibility: wp.array2d[wp.uint32],
        vpls: VplClusters,
        indirect: Indirect,
        begin: int,
        end: int,
        stopped: wp.array[float],
    ) -> None:
        """One thread an SP: rays number begin … end − 1 towards light that its clusters see.

        listed (place,): which SPs; all, in order, for ray 0. stopped (sp,): the share of rays so far that was stopped.
        """
        place = first + wp.tid()
        if begin == 0:
            stopped[place] = 0.0
        if place >= count[0]:
            return
        sp = place
        if begin > 0:
            sp = listed[place]
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        geometric = gbuffer.geometric[pixel]
        number = stopped[sp] * float(begin)
        for check in range(begin, end):
            state = hashed(wp.uint32(pixel) ^ hashed(CHECK_KEY + wp.uint32(check)))
            vpl = target_in(indirect.word[check, sp], sp, position, normal, clusters, visibility, vpls, state)
            if vpl >= 0 and not connect(scene, position, geometric, vpls.position[vpl], vpls.normal[vpl]):
                number += 1.0
        stopped[sp] = number / float(end)

    return kernel


@wp.kernel
def flag_kernel(first: int, stopped: wp.array[float], flags: wp.array[int]) -> None:
    """One thread an SP: 1 where its first ray was stopped."""
    sp = first + wp.tid()
    flags[sp] = int(stopped[sp] > 0.0)


@wp.kernel
def list_kernel(first: int, flags: wp.array[int], totals: wp.array[int], listed: wp.array[int],
                count: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: lists the flagged ones in their order, as many as `listed` holds; totals: sums of the flags."""
    sp = first + wp.tid()
    place = totals[sp] - 1
    if flags[sp] == 1 and place < listed.shape[0]:
        listed[place] = sp
    if sp == flags.shape[0] - 1:
        count[0] = wp.min(totals[sp], listed.shape[0])


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
        self._stopped = wp.zeros(pixels, dtype=float, device=device)
        self._flags = wp.zeros(pixels, dtype=int, device=device)
        self._totals = wp.zeros(pixels, dtype=int, device=device)
        self._listed = wp.zeros(max(1, int(pixels * CONFIRMED_SHARE)), dtype=int, device=device)
        self._list_count = wp.zeros(1, dtype=int, device=device)
        self._keys = wp.zeros(2 * pixels, dtype=int, device=device)
        self._order = wp.zeros(2 * pixels, dtype=int, device=device)
        self._partials = wp.zeros(PARTIALS, dtype=float, device=device)
        self._mean = wp.zeros(1, dtype=float, device=device)
        self._selected = wp.zeros(2 * capacity, dtype=int, device=device)
        self._pixels = wp.zeros(capacity, dtype=int, device=device)
        self._light = wp.zeros(capacity * WORDS_AT_ONCE, dtype=wp.vec3, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)

    def select(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters, need: wp.array,
               visibility: Visibility, vpls: VplClusters, indirect: Indirect) -> None:  # fmt: skip
        """Find the SPs of `indirect` that are most likely far too bright."""
        device = self.device
        check = check_kernel(connection(scene))
        clustering: list[Any] = [clusters, visibility.words, vpls, indirect]
        inputs = [scene, gbuffer, sps.pixels, self._listed, sps.count, *clustering, 0, 1, self._stopped]
        launch(check, sps.capacity, inputs, device)
        launch(flag_kernel, sps.capacity, [self._stopped, self._flags], device)
        running_total(self._flags, self._totals)
        inputs = [self._flags, self._totals, self._listed, self._list_count]
        launch(list_kernel, sps.capacity, inputs, device)
        inputs = [scene, gbuffer, sps.pixels, self._listed, self._list_count, *clustering, 1, CHECKS, self._stopped]
        launch(check, len(self._listed), inputs, device)
        launch(brightness_kernel, PARTIALS, [sps.count, indirect, self._partials], device)
        launch(mean_kernel, 1, [sps.count, self._partials, self._mean], device)
        inputs = [sps.count, need, indirect, self._stopped, self._mean, self._keys]
        launch(dispute_kernel, sps.capacity, inputs, device)
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

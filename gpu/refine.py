"""Rays of their own for the shading points that fuzzy clusters serve worst. Beyond the 2022 paper.

Each of them (gpu.dispute tells which) gets one ray for each 32 VPL clusters, which are neighbours: to one of them,
drawn in proportion to its light, whose answer stands for all 32.
"""

from functools import cache

import warp as wp

from gpu.device import launch
from gpu.dispute import WorstPoints
from gpu.gbuffer import GBuffer
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import Indirect, reflectance
from gpu.transfer import brightness, unoccluded
from gpu.vpl_clusters import VplClusters

# Words of 32 VPL clusters that are traced at a time; bounds the memory of the answers.
WORDS_AT_ONCE = 64


@wp.struct
class Pick:
    """One VPL cluster of a word, drawn in proportion to its light; `light` is the whole word's irradiance [W/m²].

    cluster is −1 when the word sends no light.
    """

    cluster: int
    light: wp.vec3


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
    """Re-shades up to `capacity` SPs with rays of their own; its array is allocated once."""

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.device = device
        self._light = wp.zeros(capacity * WORDS_AT_ONCE, dtype=wp.vec3, device=device)

    def run(
        self, scene: SceneData, gbuffer: GBuffer, points: WorstPoints, vpls: VplClusters, indirect: Indirect
    ) -> None:
        """Overwrite the indirect radiance of `points` by what rays of their own say."""
        words, capacity = -(-vpls.count // 32), len(points.pixels)
        for first_word in range(0, words, WORDS_AT_ONCE):
            run = min(WORDS_AT_ONCE, words - first_word)
            inputs = [scene, gbuffer, points.pixels, points.count, vpls, first_word, self._light]
            launch(word_kernel(connection(scene)), run * capacity, inputs, self.device)
            inputs = [gbuffer, points.pixels, points.count, self._light, run, first_word == 0, indirect.radiance]
            launch(sum_kernel, capacity, inputs, self.device)

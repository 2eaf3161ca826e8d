"""Rays of their own for the shading points that fuzzy clusters serve worst. Beyond the 2022 paper.

Each of them (gpu.dispute tells which) takes VPL clusters 32 at a time, which are neighbours. A word of 32 gets rays in
proportion to its light, one at least, to clusters that are drawn in proportion to theirs; their answers stand for all.
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


# Rays that an SP's whole believed light is worth, beyond one for each word.
RAYS_FOR_ALL_LIGHT = wp.constant(8.0)
MOST_RAYS = 4
Targets = wp.types.vector(length=MOST_RAYS, dtype=int)


@wp.kernel
def believed_kernel(first: int, pixels: wp.array[int], count: wp.array[int], radiance: wp.array[wp.vec3],
                    believed: wp.array[float]) -> None:  # fmt: skip
    """One thread a refined SP: keeps the brightness that fuzzy visibility gave it. believed: (place,)."""
    place = first + wp.tid()
    if place < count[0]:
        believed[place] = brightness(radiance[pixels[place]])


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
        believed: wp.array[float],
        vpls: VplClusters,
        first_word: int,
        light: wp.array[wp.vec3],
    ) -> None:
        """One thread a word of 32 VPL clusters at one SP: their light there, judged by systematically drawn rays.

        light: (word − first_word, place), flattened [W/m²].
        """
        index = first + wp.tid()
        place = index % pixels.shape[0]
        word = first_word + index // pixels.shape[0]
        if place >= count[0]:
            return
        pixel = pixels[place]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        geometric = gbuffer.geometric[pixel]
        light[index] = wp.vec3(0.0, 0.0, 0.0)
        whole = wp.vec3(0.0, 0.0, 0.0)
        begin = 32 * word
        end = wp.min(begin + 32, vpls.count)
        for vpl in range(begin, end):
            whole += unoccluded(position, normal, vpls, vpl)
        total = brightness(whole)
        if total <= 0.0:
            return
        share = brightness(wp.cw_mul(whole, reflectance(gbuffer, pixel))) / (believed[place] + 1.0e-30)
        rays = wp.min(int(wp.min(RAYS_FOR_ALL_LIGHT * share, float(MOST_RAYS))) + 1, MOST_RAYS)
        # All targets are drawn before the first ray, so that the rays of a warp's threads run together.
        targets = Targets()
        drawn = int(0)
        step = total / float(rays)
        mark = step * float(hashed(wp.uint32(pixel) ^ hashed(wp.uint32(word)))) * TO_UNIT
        passed = float(0.0)
        for vpl in range(begin, end):
            amount = brightness(unoccluded(position, normal, vpls, vpl))
            passed += amount
            for _ray in range(wp.static(MOST_RAYS)):
                if amount > 0.0 and mark < passed and drawn < rays:
                    for slot in range(wp.static(MOST_RAYS)):
                        if slot == drawn:
                            targets[slot] = vpl
                    drawn += 1
                    mark += step
        arrived = int(0)
        for ray in range(wp.static(MOST_RAYS)):
            if ray < drawn:
                vpl = targets[ray]
                if connect(scene, position, geometric, vpls.position[vpl], vpls.normal[vpl]):
                    arrived += 1
        light[index] = whole * (float(arrived) / float(wp.max(drawn, 1)))

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
    """Re-shades up to `capacity` SPs with rays of their own; its arrays are allocated once."""

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.device = device
        self._believed = wp.zeros(capacity, dtype=float, device=device)
        self._light = wp.zeros(capacity * WORDS_AT_ONCE, dtype=wp.vec3, device=device)

    def run(
        self, scene: SceneData, gbuffer: GBuffer, points: WorstPoints, vpls: VplClusters, indirect: Indirect
    ) -> None:
        """Overwrite the indirect radiance of `points` by what rays of their own say."""
        inputs = [points.pixels, points.count, indirect.radiance, self._believed]
        launch(believed_kernel, len(points.pixels), inputs, self.device)
        words, capacity = -(-vpls.count // 32), len(points.pixels)
        for first_word in range(0, words, WORDS_AT_ONCE):
            run = min(WORDS_AT_ONCE, words - first_word)
            inputs = [scene, gbuffer, points.pixels, points.count, self._believed, vpls, first_word, self._light]
            launch(word_kernel(connection(scene)), run * capacity, inputs, self.device)
            inputs = [gbuffer, points.pixels, points.count, self._light, run, first_word == 0, indirect.radiance]
            launch(sum_kernel, capacity, inputs, self.device)

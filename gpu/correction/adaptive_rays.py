"""More rays for the shading points that may be brightest, where surfaces are uneven. Beyond the 2022 paper.

Errors grow with light, their squares with its square. Where the sun shines on mouldings, one SP in seven holds three
quarters of what the clusters of a whole living-room are wrong by, and its neighbours have other light. So such SPs send
more rays, drawn from all their light in even steps, so that each part of it has its share. What they find is shared
with the nearest of them alone.
"""

from functools import cache

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.color import brightness
from gpu.core.device import allocate, launch
from gpu.core.image_size import image_of
from gpu.correction.adaptive_ray_sampling import RAYS, TRUST, Rays, draw_kernel, near_kernel, step_kernel
from gpu.correction.brightness import SAMPLES, MeanBrightness
from gpu.correction.top_k import LAST, Selection
from gpu.correction.vpl_sampling import sees_member_of
from gpu.denoise.atrous import ATROUS_PARAMETERS, luminance_weight
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connection
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import is_anchor_only
from gpu.indirect.far_field import FarLight
from gpu.indirect.irradiance import CHECKS, NEAR_PARTS, Indirect
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.form_factor import light_of
from gpu.vpl.vpl_clusters import VplClusters

# Bright is what may have this share of the brightness that only so many of the picture's SAMPLES are above.
LEAST_BRIGHT, BRIGHTER = wp.constant(0.6), 10
STEPS_PER_OCTAVE, MOST_OCTAVES = wp.constant(16.0), wp.constant(8.0)
# What frames before knew counts as the rays of so many of them, at most.
FRAMES = wp.constant(6)
# Of what shared light lacks, an SP's own rays tell this share, those of listed SPs about it the rest. What is so much
# darker, as gpu.correction.outlier_shading leaves it, is shown as it is.
OWN, DARKER = wp.constant(0.45), wp.constant(0.3)
# PowerCdf of pixels 0, 1 and 2 away on each axis.
BINOMIAL = wp.constant(wp.vec3(6.0, 4.0, 1.0))


@wp.kernel
def key_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int], listed: wp.array[int],
               width: int, height: int, indirect: Indirect, samples: wp.array[float], bright: int,
               keys: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: how bright it may be, relative to sample `bright` of the picture, as a key; brightest first.

    listed (pixel,): 1 where there is an SP. None is chosen that speaks for the pixels beside it.
    """
    sp = first + wp.tid()
    keys[sp] = LAST
    if sp >= count[0]:
        return
    pixel = pixels[sp]
    most = (indirect.unoccluded_near[sp] + indirect.unoccluded_far[sp]) * brightness(reflectance(gbuffer, pixel))
    ratio = most / (LEAST_BRIGHT * samples[bright] + 1.0e-30)
    if ratio >= 1.0 and not is_anchor_only(listed, pixel, image_of(width, height)):
        keys[sp] = wp.clamp(int(STEPS_PER_OCTAVE * (MOST_OCTAVES - wp.log2(ratio))), 0, LAST - 1)


@cache
def trace_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.device_scene.rays.connected and connected_solid."""
    sees = sees_member_of(connect)

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        count: wp.array[int],
        vpls: VplClusters,
        rays: Rays,
    ) -> None:
        """One thread a ray: adds its light if nothing stops it."""
        index = first + wp.tid()
        if index >= RAYS * count[0]:
            return
        place = index % count[0]
        ray = index // count[0]
        vpl = rays.vpl[ray, place]
        if vpl < 0:
            return
        if sees(scene, gbuffer, pixels[place], vpls, vpl):
            rays.found[ray, place] += rays.share[ray, place]

    return kernel


@wp.kernel
def take_kernel(first: int, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters, rays: Rays,
                told: wp.array[wp.vec3], frames: wp.array[int], light: wp.array[wp.vec3], irradiance: wp.array[wp.vec3],
                places: wp.array[int], lacking: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a listed SP: takes what its rays found into its `light`, and tells what its irradiance then lacks.

    told, light, irradiance (pixel,): as its clusters tell it, as its own rays do, and as neighbours share it; frames
    (pixel,): how many frames before knew the light; places (pixel,): where an SP is listed, beyond `count` where it is
    shown as it is; lacking (place,) [W/m²].
    """
    place = first + wp.tid()
    if place >= count[0]:
        return
    pixel = pixels[place]
    total = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(RAYS):
        vpl = rays.vpl[ray, place]
        if vpl >= 0:
            total += light_of(vpls, vpl, rays.found[ray, place])
    found = told[pixel] * TRUST + total / float(RAYS)
    known = CHECKS * wp.min(frames[pixel] + 1, FRAMES)
    mean = light[pixel] + (found - light[pixel]) * (float(RAYS) / float(RAYS + known))
    light[pixel] = mean
    lacking[place] = mean - irradiance[pixel]
    places[pixel] = wp.where(brightness(irradiance[pixel]) < DARKER * brightness(mean), count[0], place)


@wp.kernel
def share_kernel(first: int, gbuffer: GBuffer, width: int, height: int, pixels: wp.array[int], count: wp.array[int],
                 places: wp.array[int], lacking: wp.array[wp.vec3], told: wp.array[wp.vec3],
                 irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a listed SP: adds to its `irradiance` what that lacks, in part as listed SPs about it find.

    Arrays as `take_kernel` left them; binomial weights, where the told light is alike.
    """
    place = first + wp.tid()
    if place >= count[0]:
        return
    pixel = pixels[place]
    if places[pixel] != place:
        return
    x = pixel % width
    y = pixel // width
    own = brightness(told[pixel])
    total = float(0.0)
    mixed = wp.vec3(0.0, 0.0, 0.0)
    for neighbour in range(25):
        dx = neighbour % 5 - 2
        dy = neighbour // 5 - 2
        column = x + dx
        row = y + dy
        if column >= 0 and column < width and row >= 0 and row < height:
            other = row * width + column
            at = places[other]
            if at < count[0] and pixels[at] == other:
                weight = BINOMIAL[wp.abs(dx)] * BINOMIAL[wp.abs(dy)]
                weight *= edge_stopping_weight(gbuffer, pixel, other, 2, wp.static(ATROUS_PARAMETERS.plane_tolerance))
                weight *= luminance_weight(own, brightness(told[other]), wp.static(ATROUS_PARAMETERS.guide_tolerance))
                total += weight
                mixed += lacking[at] * weight
    lacks = lacking[place] * OWN + mixed * ((1.0 - OWN) / wp.max(total, 1.0e-20))
    irradiance[pixel] = wp.max(irradiance[pixel] + lacks, wp.vec3(0.0, 0.0, 0.0))


class BrightPoints(Selection):
    """Of an image of `size` (width, height) the at most `capacity` SPs that may be brightest, with RAYS rays for each.

    Its arrays are allocated once.
    """

    def __init__(self, size: tuple[int, int], capacity: int, device: wp.Device) -> None:
        super().__init__(size[0] * size[1], capacity, int(LAST), device)
        self._size = size
        self._samples = wp.zeros(2 * int(SAMPLES), dtype=float, device=device)
        self._sample_order = wp.zeros(2 * int(SAMPLES), dtype=int, device=device)
        self._rays: Rays = allocate(Rays, self.capacity, device, RAYS)
        self._places = wp.zeros(size[0] * size[1], dtype=int, device=device)
        self._lacking = wp.zeros(self.capacity, dtype=wp.vec3, device=device)

    def trace(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters, words: wp.array,
              vpls: VplClusters, far: FarLight, indirect: Indirect, seed: wp.array,
              picture: MeanBrightness) -> None:  # fmt: skip
        """Choose of `sps`, shaded by all these, and trace the rays.

        words: visibility bits of `clusters`; seed: (1,); picture: how bright it is.
        """
        fuzziness, device, rays = clusters.cluster.shape[0], self.device, RAYS * self.capacity
        wp.copy(self._samples, picture.samples, count=int(SAMPLES))
        radix_sort_pairs(self._samples, self._sample_order, int(SAMPLES))
        inputs = [gbuffer, sps.pixels, sps.count, sps.listed, *self._size, indirect]
        launch(key_kernel, sps.capacity, [*inputs, self._samples, int(SAMPLES) - 1 - BRIGHTER, self.keys], device)
        self.choose(sps)
        chosen = self.pixels, self.numbers, self.count
        launch(step_kernel, rays, [*chosen, indirect, seed, self._rays], device)
        inputs = [gbuffer, *chosen, clusters, vpls, far, indirect, self._rays]
        launch(near_kernel(fuzziness), NEAR_PARTS * self.capacity, inputs, device)
        inputs = [gbuffer, *chosen, clusters, words, vpls, far, indirect, seed, self._rays]
        launch(draw_kernel(fuzziness), rays, inputs, device)
        inputs = [scene, gbuffer, self.pixels, self.count, vpls, self._rays]
        launch(trace_kernel(connection(scene)), rays, inputs, device)

    def take(self, gbuffer: GBuffer, vpls: VplClusters, told: wp.array, frames: wp.array, light: wp.array,
             irradiance: wp.array) -> None:  # fmt: skip
        """Have what the rays found in `light` and `irradiance`, as the kernels tell; (pixel,) each."""
        listed, lacking = [self.pixels, self.count], [self._places, self._lacking]
        inputs = [*listed, vpls, self._rays, told, frames, light, irradiance, *lacking]
        launch(take_kernel, self.capacity, inputs, self.device)
        inputs = [gbuffer, *self._size, *listed, *lacking, told, irradiance]
        launch(share_kernel, self.capacity, inputs, self.device)

"""More rays for the shading points that may be brightest, where surfaces are uneven. Beyond the 2022 paper.

Errors grow with light, their squares with its square. Where the sun shines on mouldings, one SP in seven holds three
quarters of what the clusters of a whole living-room are wrong by, and its neighbours have other light. So such SPs send
more rays, drawn from all their light in even steps, so that each part of it has its share. What they find is shared
with the nearest of them alone.
"""

from dataclasses import dataclass

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.parameters import parameters
from gpu.core.sample_mean import SAMPLES
from gpu.correction.adaptive_ray_sampling import RAYS, adaptive_near_kernel, adaptive_ray_kernel, adaptive_step_kernel
from gpu.correction.brightness import MeanBrightness
from gpu.correction.top_k import LAST, Selection
from gpu.correction.vpl_sampling import VPL_SAMPLE_PARAMETERS
from gpu.denoise.atrous import ATROUS_PARAMETERS, luminance_weight
from gpu.device_scene.data import SceneData
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import is_anchor_only
from gpu.indirect.clustered_light import ClusteredLight
from gpu.indirect.far_field import light_seen
from gpu.indirect.irradiance import CHECKS, NEAR_PARTS, Indirect
from gpu.vpl.form_factor import light_of
from gpu.vpl.shadow_rays import NO_RAY, ShadowRays, colouring, ray_index, shadow_rays, target_of, trace_shadow_rays
from gpu.vpl.vpl_clusters import VplClusters

# How keys encode brightness.
STEPS_PER_OCTAVE, MOST_OCTAVES = wp.constant(16.0), wp.constant(8.0)
# Weights of pixels 0, 1 and 2 away on each axis.
BINOMIAL = wp.constant(wp.vec3(6.0, 4.0, 1.0))


@wp.struct
@dataclass
class AdaptiveRayParameters:
    """Which SPs have more rays, and how much these count.

    least_bright: SPs are bright that may have this share of the brightness that only `brighter` of the picture's
    SAMPLES exceed.
    least_found: so many of an SP's rays must find light by what its clusters see: of fewer, as in a dark room beside a
    far brighter place, each that does would be a firefly.
    trust: rays find what clusters believe to be off, of which this share is taken for granted: where clusters are right
    that leaves little noise, where all is hidden, rays do that alone.
    most_frames: what frames before knew counts as the rays of so many of them, at most.
    own_share: of what shared light lacks, an SP's own rays tell this share, those of listed SPs about it the rest.
    darker: what has less than this share of its light, and of what clusters tell, is shown as it is:
    gpu.correction.outlier_shading leaves so little, gpu.correction.visibility_correction more.
    least_light: of what clusters tell, this share of which remains where rays of one frame find less, as
    gpu.correction.visibility_correction has it for fewer rays.
    """

    least_bright: float = 0.6
    brighter: int = 10
    least_found: float = 0.1
    trust: float = 0.6
    most_frames: int = 6
    own_share: float = 0.45
    darker: float = 0.25
    least_light: float = 0.05


ADAPTIVE_RAY_PARAMETERS: AdaptiveRayParameters = parameters(AdaptiveRayParameters)


@wp.struct
class PixelLight:
    """What is known of pixels' light [W/m²], (pixel,) each.

    clustered: as clusters tell it; frames: how many frames before knew the `light` that an SP's own rays tell;
    irradiance: as neighbours share it.
    """

    clustered: wp.array[wp.vec3]
    frames: wp.array[int]
    light: wp.array[wp.vec3]
    irradiance: wp.array[wp.vec3]


@wp.struct
class Residual:
    """What the irradiance of listed SPs lacks.

    light (place,) [W/m²]; place (pixel,): where an SP is listed, beyond the count where it is shown as it is.
    """

    light: wp.array[wp.vec3]
    place: wp.array[int]


@wp.kernel
def adaptive_key_kernel(first: int, gbuffer: GBuffer, points: PointList, listed: wp.array[int], image: ImageSize,
                        indirect: Indirect, least: wp.array[float], keys: wp.array[int],
                        by: AdaptiveRayParameters) -> None:  # fmt: skip
    """One thread an SP: how bright it may be, relative to `least` (1,), as a key, keys (sp,); brightest first.

    listed (pixel,): 1 where there is an SP. None is chosen that speaks for the pixels beside it.
    """
    sp = first + wp.tid()
    keys[sp] = LAST
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    whole = indirect.unoccluded_near[sp] + indirect.unoccluded_far[sp]
    seen = light_seen(indirect.near_importance[sp] + indirect.far_importance[sp], whole)
    ratio = whole * brightness(reflectance(gbuffer, pixel)) / (by.least_bright * least[0] + 1.0e-30)
    found = float(RAYS) * seen >= by.least_found * whole
    if ratio >= 1.0 and found and not is_anchor_only(listed, pixel, image):
        keys[sp] = wp.clamp(int(STEPS_PER_OCTAVE * (MOST_OCTAVES - wp.log2(ratio))), 0, LAST - 1)


@wp.kernel
def adaptive_irradiance_kernel(first: int, points: PointList, vpls: VplClusters, rays: ShadowRays,
                               known: PixelLight, residual: Residual, by: AdaptiveRayParameters) -> None:  # fmt: skip
    """One thread a listed SP: takes what its rays found into its light, and tells what its irradiance then lacks."""
    place = first + wp.tid()
    if place >= points.count[0]:
        return
    pixel = points.pixels[place]
    total = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(RAYS):
        index = ray_index(rays, place, ray)
        vpl = target_of(rays.vpl[index])
        if vpl != NO_RAY:
            share = rays.share[index]
            found = -by.trust * rays.cluster_visibility[index] * share
            if rays.vpl[index] == vpl:
                found += share
            total += light_of(vpls, vpl, found) + wp.cw_mul(light_of(vpls, vpl, share), colouring(rays, index))
    found_light = known.clustered[pixel] * by.trust + total / float(RAYS)
    before = CHECKS * wp.min(known.frames[pixel] + 1, by.most_frames)
    light = known.light[pixel]
    mean = light + (found_light - light) * (float(RAYS) / float(RAYS + before))
    known.light[pixel] = mean
    residual.light[place] = mean - known.irradiance[pixel]
    whole = wp.min(brightness(mean), brightness(known.clustered[pixel]))
    is_darker = brightness(known.irradiance[pixel]) < by.darker * whole
    residual.place[pixel] = wp.where(is_darker, points.count[0], place)


@wp.kernel
def residual_filter_kernel(first: int, gbuffer: GBuffer, image: ImageSize, points: PointList, residual: Residual,
                           known: PixelLight, by: AdaptiveRayParameters) -> None:  # fmt: skip
    """One thread a listed SP: adds to its irradiance what that lacks, in part as listed SPs about it find.

    Arrays as `adaptive_irradiance_kernel` left them; binomial weights, where the clusters' light is alike.
    """
    place = first + wp.tid()
    if place >= points.count[0]:
        return
    pixel = points.pixels[place]
    if residual.place[pixel] != place:
        return
    x = pixel % image.width
    y = pixel // image.width
    own = brightness(known.clustered[pixel])
    total = float(0.0)
    mixed = wp.vec3(0.0, 0.0, 0.0)
    for neighbour in range(25):
        dx = neighbour % 5 - 2
        dy = neighbour // 5 - 2
        column = x + dx
        row = y + dy
        if column >= 0 and column < image.width and row >= 0 and row < image.height:
            other = row * image.width + column
            at = residual.place[other]
            if at < points.count[0] and points.pixels[at] == other:
                weight = BINOMIAL[wp.abs(dx)] * BINOMIAL[wp.abs(dy)]
                weight *= edge_stopping_weight(gbuffer, pixel, other, 2, wp.static(ATROUS_PARAMETERS.plane_tolerance))
                weight *= luminance_weight(
                    own, brightness(known.clustered[other]), wp.static(ATROUS_PARAMETERS.guide_tolerance)
                )
                total += weight
                mixed += residual.light[at] * weight
    lacks = residual.light[place] * by.own_share + mixed * ((1.0 - by.own_share) / wp.max(total, 1.0e-20))
    before = known.irradiance[pixel]
    least = known.clustered[pixel] * (by.least_light / float(known.frames[pixel] + 1))
    known.irradiance[pixel] = wp.max(before + lacks, wp.min(before, least))


class BrightPoints(Selection):
    """Of an image of `size` (width, height) the at most `capacity` SPs that may be brightest, with RAYS rays for each.

    Its arrays are allocated once.
    """

    def __init__(self, size: tuple[int, int], capacity: int, device: wp.Device, *, tinted: bool = False) -> None:
        """tinted: as of gpu.vpl.shadow_rays.shadow_rays."""
        super().__init__(size[0] * size[1], capacity, int(LAST), device)
        self._image = image_size(size)
        self._samples = wp.zeros(2 * int(SAMPLES), dtype=float, device=device)
        self._sample_order = wp.zeros(2 * int(SAMPLES), dtype=int, device=device)
        bright = int(SAMPLES) - 1 - ADAPTIVE_RAY_PARAMETERS.brighter
        self._least = self._samples[bright : bright + 1]
        by_ray = {"side_by_side": False, "control_variate": True, "tinted": tinted}
        self._rays = shadow_rays(self.capacity, RAYS, device, **by_ray)
        self._residual = Residual()
        self._residual.light = wp.zeros(self.capacity, dtype=wp.vec3, device=device)
        self._residual.place = wp.zeros(size[0] * size[1], dtype=int, device=device)

    def trace(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, known: ClusteredLight, indirect: Indirect,
              seed: wp.array, picture: MeanBrightness) -> None:  # fmt: skip
        """Choose of `sps`, shaded by what is `known`, and trace the rays; seed: (1,); picture: how bright it is."""
        fuzziness, device, rays = known.clusters.cluster.shape[0], self.device, RAYS * self.capacity
        listed, least = (sps.points, sps.listed), self._least
        wp.copy(self._samples, picture.samples, count=int(SAMPLES))
        radix_sort_pairs(self._samples, self._sample_order, int(SAMPLES))
        inputs = [gbuffer, *listed, self._image, indirect, least, self.keys, ADAPTIVE_RAY_PARAMETERS]
        launch(adaptive_key_kernel, sps.capacity, inputs, device)
        self.choose(sps)
        launch(adaptive_step_kernel, rays, [self.points, indirect, seed, self._rays], device)
        inputs = [gbuffer, self.points, known, indirect, self._rays]
        launch(adaptive_near_kernel(fuzziness), NEAR_PARTS * self.capacity, inputs, device)
        inputs = [gbuffer, self.points, known, indirect, seed, self._rays, VPL_SAMPLE_PARAMETERS]
        launch(adaptive_ray_kernel(fuzziness), rays, inputs, device)
        trace_shadow_rays(scene, gbuffer, self.points, known.vpls, self._rays)

    def take(self, gbuffer: GBuffer, vpls: VplClusters, clustered: wp.array, frames: wp.array, light: wp.array,
             irradiance: wp.array) -> None:  # fmt: skip
        """Have what the rays found in `light` and `irradiance`, as the kernels tell; (pixel,) each."""
        known = PixelLight()
        known.clustered, known.frames, known.light, known.irradiance = clustered, frames, light, irradiance
        inputs = [self.points, vpls, self._rays, known, self._residual, ADAPTIVE_RAY_PARAMETERS]
        launch(adaptive_irradiance_kernel, self.capacity, inputs, self.device)
        inputs = [gbuffer, self._image, self.points, self._residual, known, ADAPTIVE_RAY_PARAMETERS]
        launch(residual_filter_kernel, self.capacity, inputs, self.device)

"""Rays of the final gather that are drawn towards the brightest of what photons light (gpu.indirect.bright_photons)."""

from functools import cache
from typing import Any

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, allocate, launch
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.indirect.bright_photons import BrightPhotons, any_bright, draw_bright, ray_share
from gpu.indirect.illumination import Illumination
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sp.centres import ShadingClusters

# The sequence of Sobol points beside those of gather rays and of paths on from them.
GUIDED_PAIR = wp.constant(64)
# Of the distance of a photon, within which a ray towards it has met its surface.
NEAR_PHOTON = wp.constant(1.0e-3)


@wp.struct
class GuidedRays:
    """What these find, (cluster · guided,) each. direction: unit; radiance [W/m²/sr], over how often the cosine draws
    them.
    """

    direction: wp.array[wp.vec3]
    radiance: wp.array[wp.vec3]


@wp.struct
class GuidedLight:
    """What one finds along unit `direction`. radiance: over how often the cosine draws it [W/m²/sr], 0 where it does
    not meet its photon; earlier: what of that is not of the last bounce.
    """

    direction: wp.vec3
    radiance: wp.vec3
    earlier: wp.vec3


def allocate_guided(rays: int, device: wp.Device) -> GuidedRays:
    """`rays` rays in all."""
    guided: GuidedRays = allocate(GuidedRays, rays, device)
    return guided


@cache
def guided_ray(lookup: wp.Function, data: Any) -> wp.Function:
    """The function that traces one; lookup, data: as of gpu.indirect.illumination.Illumination.

    ray(scene, lit, bright, position, normal, geometric_normal, value, ratio) has the GuidedLight that a surface point
    gets of the photon which `value` draws; ratio: of rays that are drawn so to those drawn by the cosine.
    """

    @wp.func
    def ray(scene: SceneData, lit: data, bright: BrightPhotons, position: wp.vec3, normal: wp.vec3,
            geometric_normal: wp.vec3, value: wp.uint32, ratio: float) -> GuidedLight:  # fmt: skip
        light = GuidedLight()
        photon = draw_bright(bright, value)
        target = bright.photons.position[photon]
        origin = offset_origin(position, geometric_normal, target - position)
        distance = wp.length(target - origin)
        light.direction = wp.normalize(target - origin)
        leaves = wp.dot(light.direction, geometric_normal) > 0.0
        if not leaves or wp.dot(light.direction, bright.photons.normal[photon]) >= 0.0:
            return light
        hit = closest_hit(scene, origin, light.direction, RAY_LENGTH)
        if hit.face == NO_HIT or wp.abs(hit.t - distance) > NEAR_PHOTON * distance:
            return light
        surface = met_at(scene, hit, light.direction)
        estimate = lookup(lit, surface.position, surface.geometric_normal)
        way = surface.position - position
        share = ray_share(bright, estimate.irradiance, way, normal, surface.geometric_normal, ratio)
        if share < 1.0:
            reflected = even_reflectance(surface, -light.direction) * (share / PI)
            light.radiance = wp.cw_mul(reflected, estimate.irradiance)
            light.earlier = wp.cw_mul(reflected, estimate.earlier)
            if scene.part_glass:
                tint = crossed_tint(scene, origin, light.direction, hit.t, False)
                light.radiance = wp.cw_mul(light.radiance, tint)
                light.earlier = wp.cw_mul(light.earlier, tint)
        return light

    return ray


@made_for(*LOOK)
def guided_ray_kernel(features: SceneFeatures, lookup: wp.Function, data: Any) -> wp.Kernel:
    """The kernel for scenes of these `features`; lookup, data: as of gpu.indirect.illumination.Illumination."""
    specialise, ray = specialisation(features), guided_ray(lookup, data)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def guided_ray_kernel(first: int, scene: SceneData, clusters: ShadingClusters, lit: data, bright: BrightPhotons,
                          seeds: wp.array[int], out: GuidedRays) -> None:  # fmt: skip
        """One thread a ray: its light, if it meets the photon that it is drawn to. seeds: one element."""
        index = first + wp.tid()
        out.radiance[index] = wp.vec3(0.0, 0.0, 0.0)
        cluster = index // bright.guided
        if any_bright(bright) == 0 or clusters.spacing[cluster] == 0.0:
            return
        scene = specialise(scene)
        value = sobol_pair(index % bright.guided, GUIDED_PAIR, pixel_seed(cluster, seeds[0])).a
        normal = clusters.normal[cluster]
        geometric_normal = clusters.geometric_normal[cluster]
        ratio = float(bright.guided) / float(bright.rays)
        light = ray(scene, lit, bright, clusters.position[cluster], normal, geometric_normal, value, ratio)
        out.direction[index] = light.direction
        out.radiance[index] = light.radiance

    return guided_ray_kernel


def trace_guided(scene: SceneData, clusters: ShadingClusters, light: Illumination, bright: BrightPhotons,
                 seed: wp.array, features: SceneFeatures, out: GuidedRays) -> None:  # fmt: skip
    """Trace the rays of `clusters` towards what is `bright` of `light`, by `seed` (1,)."""
    kernel = guided_ray_kernel(features, light.lookup, light.data)
    launch(kernel, len(out.radiance), [scene, clusters, light.lit, bright, seed, out], out.radiance.device)

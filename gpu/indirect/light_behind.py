"""Indirect light that translucent surfaces are lit by from behind: by a ray of each shading point, which ends in the
light that VPLs or photons know.

With VPLs it joins near-field light, which is shared between neighbours and kept in a walk: both are as noisy. Frames
whose chains are drawn have none (gpu.gbuffer.drawn_side).
"""

from typing import Any

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, launch
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.gbuffer.gbuffer import GBuffer, behind_share
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.illumination import Illumination
from gpu.indirect.lobe_light import LOBE_REGISTERS, NO_EMISSION, KnownLight, light_along, lobe_ray
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction

# Of the sample sequences of a frame's seed, those that nothing else takes, from this one on.
BEHIND_PAIR = wp.constant(69)
# Rays of a point at the most, until one ends where photons tell of light, or in the open.
PHOTON_RAYS = wp.constant(4)


@wp.func
def other_side(gbuffer: GBuffer, pixel: int) -> Surface:
    """Where an SP is, its normals to the other side."""
    side = Surface()
    side.position = gbuffer.position[pixel]
    side.geometric_normal = -gbuffer.geometric_normal[pixel]
    side.normal = -gbuffer.normal[pixel]
    return side


@made_for(*LOOK, "panes", "glass", "backdrop", "environment")
def behind_ray_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"max_unroll": 1, "fast_math": True}, cuda_max_registers=LOBE_REGISTERS)
    def behind_ray_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        known: KnownLight,
        seeds: wp.array[int],
        light: wp.array[wp.vec3],
    ) -> None:
        """One thread an SP: adds the irradiance from behind to its `light` (pixel,) [W/m²], as much as would be
        reflected by its albedo. seeds: one element.
        """
        sp = first + wp.tid()
        if sp >= points.count[0]:
            return
        pixel = points.pixels[sp]
        share = behind_share(gbuffer, pixel)
        if largest(share) <= 0.0:
            return
        scene = specialise(scene)
        place = sobol_pair(sp, BEHIND_PAIR, seeds[0])
        side = other_side(gbuffer, pixel)
        direction = cosine_direction(side.normal, place.x, place.y)
        if wp.dot(direction, side.geometric_normal) <= 0.0:
            return
        seen = light_along(scene, known, lobe_ray(side, direction, NO_EMISSION, sp, 0, seeds[0]))
        light[pixel] += wp.cw_mul(share, seen.light) * PI

    return behind_ray_kernel


def trace_behind(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, known: KnownLight, seed: wp.array,
                 light: wp.array, features: SceneFeatures) -> None:  # fmt: skip
    """Add to `light` (pixel,) of `sps` the irradiance from behind that is `known`, by rays of a `seed` (1,)."""
    inputs = [scene, gbuffer, sps.points, known, seed, light]
    launch(behind_ray_kernel(features), sps.capacity, inputs, sps.device)


@made_for(*LOOK)
def behind_photon_kernel(features: SceneFeatures, lookup: wp.Function, data: Any) -> wp.Kernel:
    """The kernel for scenes of these `features`; lookup, data: as of gpu.indirect.illumination.Illumination."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"max_unroll": 1, "fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def behind_photon_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        lit: data,
        seeds: wp.array[int],
        light: wp.array[wp.vec3],
    ) -> None:
        """One thread an SP: writes the irradiance from behind into its `light` (pixel,) [W/m²], as much as would be
        reflected by its albedo. seeds: one element.
        """
        sp = first + wp.tid()
        if sp >= points.count[0]:
            return
        pixel = points.pixels[sp]
        light[pixel] = wp.vec3(0.0, 0.0, 0.0)
        share = behind_share(gbuffer, pixel)
        if largest(share) <= 0.0:
            return
        scene = specialise(scene)
        side = other_side(gbuffer, pixel)
        for ray in range(PHOTON_RAYS):
            place = sobol_pair(sp, BEHIND_PAIR + ray, seeds[0])
            direction = cosine_direction(side.normal, place.x, place.y)
            if wp.dot(direction, side.geometric_normal) <= 0.0:
                return
            origin = offset_origin(side.position, side.geometric_normal, direction)
            hit = closest_hit(scene, origin, direction, RAY_LENGTH)
            if hit.face == NO_HIT:
                return
            surface = met_at(scene, hit, direction)
            estimate = lookup(lit, surface.position, surface.geometric_normal)
            if estimate.known:
                light[pixel] = wp.cw_mul(share, wp.cw_mul(even_reflectance(surface, -direction), estimate.irradiance))
                if scene.part_glass:
                    tint = crossed_tint(scene, origin, direction, hit.t, False)
                    light[pixel] = wp.cw_mul(light[pixel], tint)
                return

    return behind_photon_kernel


def trace_behind_by_photons(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, known: Illumination, seed: wp.array,
                            light: wp.array, features: SceneFeatures) -> None:  # fmt: skip
    """Write into `light` (pixel,) of `sps` the irradiance from behind that is `known`, by rays of a `seed` (1,)."""
    inputs = [scene, gbuffer, sps.points, known.lit, seed, light]
    launch(behind_photon_kernel(features, known.lookup, known.data), sps.capacity, inputs, sps.device)


@wp.kernel
def join_sides_kernel(first: int, gbuffer: GBuffer, points: PointList, behind: wp.array[wp.vec3],
                      irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: its irradiance (pixel,) is of its side alone before, then that of both."""
    sp = first + wp.tid()
    if sp < points.count[0]:
        pixel = points.pixels[sp]
        own = wp.vec3(1.0, 1.0, 1.0) - behind_share(gbuffer, pixel)
        irradiance[pixel] = wp.cw_mul(irradiance[pixel], own) + behind[pixel]


def join_sides(gbuffer: GBuffer, sps: ShadingPoints, behind: wp.array, irradiance: wp.array) -> None:
    """Have in the `irradiance` (pixel,) of `sps`, which is of the side that is seen, what is `behind` (pixel,), and
    near-field light.
    """
    launch(join_sides_kernel, sps.capacity, [gbuffer, sps.points, behind, irradiance], sps.device)

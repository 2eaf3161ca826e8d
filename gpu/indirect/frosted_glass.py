"""Frosted glass: what it shows in frames whose chains are not drawn, by two rays of each pixel.

They are drawn as a microfacet reflects and refracts and end in the light that VPLs know; emitters are sampled, too.
Pixels share what they find as those of glossy surfaces do.
"""

from functools import cache

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.image_size import ImageSize
from gpu.core.morton import morton_2d
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.glass import facet_of, glass_density, glass_fresnel, glass_value, sample_glass
from gpu.device_scene.panes import transmittance
from gpu.device_scene.surface import Surface, surface_at
from gpu.direct.direct_light import DirectSamples
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.lobe_light import (
    LOBE_PAIR,
    LOBE_VERTICES,
    NO_EMISSION,
    GlossParameters,
    KnownLight,
    LobeLight,
    LobeRay,
    light_along,
    lobe_reach,
)
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import BELOW_ONE, pixel_seed, sobol_pair, sobol_pair_at

# Sequences beside those of the ray.
GLASS_PAIR = wp.constant(int(LOBE_PAIR) + 2 * int(LOBE_VERTICES) + 3)


@wp.func
def hit_at(scene: SceneData, face: int, position: wp.vec3) -> Hit:
    """The hit of a triangle at a `position` on it."""
    corner = scene.triangles[face]
    last = scene.vertices[corner[2]]
    a = scene.vertices[corner[0]] - last
    b = scene.vertices[corner[1]] - last
    normal = wp.cross(a, b)
    square = wp.dot(normal, normal)
    hit = Hit()
    hit.face = face
    hit.u = wp.dot(wp.cross(position - last, b), normal) / square
    hit.v = wp.dot(wp.cross(a, position - last), normal) / square
    return hit


@wp.func
def side_share(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """The share of the light that glass sends to `view` from the side that unit `light` is on."""
    reflects = glass_fresnel(surface, wp.dot(view, facet_of(surface, view, light)))
    return wp.where(wp.dot(surface.normal, light) > 0.0, reflects, 1.0 - reflects)


@wp.func
def sampled_through(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, moment: int,
                    seed: int) -> wp.vec3:  # fmt: skip
    """An estimate of direct light that glass sends to unit `view`, weighed against a ray to either side [W/m²/sr]."""
    none = wp.vec3(0.0, 0.0, 0.0)
    if table.count == 0:
        return none
    pick = sobol_pair(moment, GLASS_PAIR, seed)
    point = sobol_pair(moment, GLASS_PAIR + 1, seed)
    sample = sample_light(scene, table, table.all_emitters, surface.position, pick.a, point)
    light = wp.cw_mul(glass_value(surface, view, sample.direction), sample.irradiance)
    if largest(light) <= 0.0:
        return none
    facing = wp.dot(surface.geometric_normal, sample.direction) > 0.0
    side = wp.where(facing, surface.geometric_normal, -surface.geometric_normal)
    light = wp.cw_mul(light, transmittance(scene, surface.position, side, sample.point, sample.normal))
    density = glass_density(surface, view, sample.direction) / side_share(surface, view, sample.direction)
    return light / (1.0 + density * sample.solid_angle)


@cache
def frosted_ray_kernel(texels: bool, panes: bool, backdrop: bool, environment: bool) -> wp.Kernel:
    """The kernel for scenes whose surfaces show `texels`, or neither textures nor masks, and with or without the others
    of gpu.device_scene.features.
    """

    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def frosted_ray_kernel(
        first: int,
        scene: SceneData,
        cameras: wp.array[CameraData],
        image: ImageSize,
        gbuffer: GBuffer,
        known: KnownLight,
        samples: DirectSamples,
        chosen: GlossParameters,
        out: LobeLight,
    ) -> None:
        """One thread a pixel: overwrites `out` where its SP is of glass that the camera's ray does not pass by what
        that shows. cameras: one element.
        """
        pixel = first + wp.tid()
        face = gbuffer.face[pixel]
        if face == NO_HIT:
            return
        if scene.materials[scene.triangle_material[face]].transmission == 0.0:
            return
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        if wp.static(not panes):
            scene.pane_count = 0
        if wp.static(not backdrop):
            scene.backdrop_count = 0
        if wp.static(not environment):
            scene.has_environment = False
        view = gbuffer.to_camera[pixel]
        surface = surface_at(scene, hit_at(scene, face, gbuffer.position[pixel]), -view)
        share = surface.glass
        if share == 0.0:
            return
        place = morton_2d(pixel % image.width, pixel // image.width)
        moment = samples.moment[0]
        point = sobol_pair_at(place, moment, LOBE_PAIR, samples.seed)
        ray = LobeRay()
        ray.position = surface.position
        ray.normal = surface.geometric_normal
        ray.place = place
        ray.moment = moment
        ray.seed = samples.seed
        light = wp.vec3(0.0, 0.0, 0.0)
        nearest = float(RAY_LENGTH)
        for side in range(2):
            sample = sample_glass(surface, view, float(side) * BELOW_ONE, point.x, point.y)
            if largest(sample.weight) > 0.0:
                part = side_share(surface, view, sample.direction)
                ray.direction = sample.direction
                ray.density = wp.where(known.direct, sample.density / part, NO_EMISSION)
                if side == 1 and not surface.thin:
                    ray.absorption = surface.absorption
                seen = light_along(scene, known, ray)
                light += wp.cw_mul(sample.weight, seen.light) * part
                nearest = wp.min(nearest, seen.distance)
        if known.direct:
            light += sampled_through(scene, known.table, surface, view, moment, pixel_seed(pixel, samples.seed))
        out.light[pixel] = light * share
        out.reach[pixel] = lobe_reach(gbuffer, pixel, cameras[0], image, nearest, chosen)

    return frosted_ray_kernel

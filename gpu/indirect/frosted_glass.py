"""Frosted glass: what it shows in frames whose chains are not drawn, by two rays of each pixel, three of a body.

They are drawn as a microfacet reflects and refracts and end in the light that VPLs know; emitters are sampled, too.
What is refracted into a body is seen by both ways on from the face where it would leave: drawn by chance, the few that
reflect into a window would leave fireflies. Pixels share what they find as those of glossy surfaces do.
"""

import warp as wp

from gpu.core.image_size import ImageSize
from gpu.core.morton import morton_2d
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.glass import attenuated, glass_density, glass_value, sample_side, side_share
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import meet, met_surface, transmittance
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface, hit_at
from gpu.direct.direct_light import DirectSamples
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.lobe_light import (
    LOBE_PAIR,
    LOBE_REGISTERS,
    LOBE_VERTICES,
    NO_EMISSION,
    NO_REACH,
    GlossParameters,
    KnownLight,
    LobeLight,
    LobeRay,
    light_along,
    lobe_coverage,
    lobe_ray,
    lobe_reach,
)
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import pixel_seed, sobol_pair, sobol_pair_at

# Sequences beside those of the ray.
GLASS_PAIR = wp.constant(int(LOBE_PAIR) + 2 * int(LOBE_VERTICES) + 3)
FACE_PAIR = wp.constant(int(GLASS_PAIR) + 2)
# Against division by zero [W/m²/sr].
LEAST_BRIGHT = wp.constant(1.0e-12)


@wp.func
def beyond_face(scene: SceneData, ray: LobeRay, side: int, x: float, y: float) -> LobeRay:
    """A ray in a body, from where it meets the face of glass: reflected there (side 0) or refracted (1), by its share;
    (x, y) is the sample of the facet. `ray` itself (0), or none (1), where it meets something else.
    """
    scene.coverage = lobe_coverage(ray, 0)  # what `light_along` meets, too
    met = meet(scene, offset_origin(ray.position, ray.normal, ray.direction), ray.direction, False)
    face = Surface()
    if met.hit.face != NO_HIT:
        face = met_surface(scene, met.hit, ray.direction)
    if face.glass < 1.0 or face.thin or largest(face.emission) > 0.0:
        ray.throughput = ray.throughput * float(1 - side)
        return ray
    view = -ray.direction
    sample = sample_side(face, view, side, x, y)
    left = wp.cw_mul(attenuated(ray.absorption, met.hit.t), sample.weight)
    ray.throughput = wp.cw_mul(ray.throughput, left)
    ray.inside = side == 0
    if ray.density > 0.0:
        ray.density = 0.0  # samples of emitters find none past a body's faces
    ray.position = face.position
    ray.normal = face.geometric_normal
    ray.direction = sample.direction
    return ray


@wp.func
def sampled_through(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, index: int,
                    seed: int) -> wp.vec3:  # fmt: skip
    """An estimate of direct light that glass sends to unit `view`, weighed against a ray to either side [W/m²/sr]."""
    none = wp.vec3(0.0, 0.0, 0.0)
    if table.count == 0:
        return none
    pick = sobol_pair(index, GLASS_PAIR, seed)
    point = sobol_pair(index, GLASS_PAIR + 1, seed)
    sample = sample_light(scene, table, table.all_emitters, surface.position, pick.a, point)
    light = wp.cw_mul(glass_value(surface, view, sample.direction), sample.irradiance)
    if largest(light) <= 0.0:
        return none
    facing = wp.dot(surface.geometric_normal, sample.direction) > 0.0
    side = wp.where(facing, surface.geometric_normal, -surface.geometric_normal)
    light = wp.cw_mul(light, transmittance(scene, surface.position, side, sample.point, sample.normal))
    density = glass_density(surface, view, sample.direction) / side_share(surface, view, sample.direction)
    return light / (1.0 + density * sample.solid_angle)


@made_for(*LOOK, "panes", "backdrop", "environment")
def frosted_ray_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"max_unroll": 1, "fast_math": True}, cuda_max_registers=LOBE_REGISTERS)
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
        scene = specialise(scene)
        view = gbuffer.to_camera[pixel]
        surface = met_at(scene, hit_at(scene, face, gbuffer.position[pixel]), -view)
        share = surface.glass
        if share == 0.0:
            return
        place = morton_2d(pixel % image.width, pixel // image.width)
        frame_index = samples.frame_index[0]
        point = sobol_pair_at(place, frame_index, LOBE_PAIR, samples.seed)
        face_point = sobol_pair_at(place, frame_index, FACE_PAIR, samples.seed)
        light = wp.vec3(0.0, 0.0, 0.0)
        distance = float(0.0)
        bright = float(0.0)
        for way in range(3):
            sample = sample_side(surface, view, wp.min(way, 1), point.x, point.y)
            if largest(sample.weight) > 0.0 and not (way == 2 and surface.thin):
                density = wp.where(known.direct, sample.density, NO_EMISSION)
                ray = lobe_ray(surface, sample.direction, density, place, frame_index, samples.seed)
                ray.throughput = sample.weight
                if way > 0 and not surface.thin:
                    ray.inside = True
                    ray.absorption = surface.absorption
                    ray = beyond_face(scene, ray, way - 1, face_point.x, face_point.y)
                if largest(ray.throughput) > 0.0:
                    seen = light_along(scene, known, ray)
                    arrives = wp.cw_mul(ray.throughput, seen.light)
                    light += arrives
                    # What shows most decides how far it is the same. Some way, where all is dark.
                    weight = largest(arrives) + LEAST_BRIGHT
                    distance += weight * seen.distance
                    bright += weight
        if known.direct:
            light += sampled_through(scene, known.table, surface, view, frame_index, pixel_seed(pixel, samples.seed))
        out.light[pixel] = light * share
        distance = distance / wp.max(bright, LEAST_BRIGHT)
        out.reach[pixel] = wp.max(lobe_reach(gbuffer, pixel, cameras[0], image, distance, chosen), NO_REACH)

    return frosted_ray_kernel

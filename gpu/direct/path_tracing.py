"""Path tracing: the reference that other methods are compared with. The same surfaces, lights and BRDF, no VPLs.

As in every method here, light is reflected by the full BRDF where the camera looks and by Lambertian surfaces before
that. Emitters are sampled at every vertex; light that a bounce meets counts by the balance heuristic (Veach 1997, 9.2).
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import closest_hit, connected, offset_origin, seen_hit
from gpu.device_scene.surface import Surface, surface_at
from gpu.direct.direct_light import DIRECT_PAIRS, area_light, delta_light
from gpu.gbuffer.camera_rays import CameraData, pixel_ray
from gpu.lights.background import background
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction

FIRST_PAIR = wp.constant(int(DIRECT_PAIRS))
PAIRS_A_BOUNCE = wp.constant(4)


@wp.struct
@dataclass
class PathSamples:
    """Which paths are traced. direct, indirect: the light that is wanted; bounces: at most so many indirect ones;
    roulette_bounce: before this one no path ends by Russian roulette.

    count: paths a pixel; before: paths that the mean has of a pixel already, which have the numbers from 0 on.
    """

    count: int = 1
    before: int = 0
    bounces: int = 4
    roulette_bounce: int = 2
    direct: bool = True
    indirect: bool = True
    seed: int = 0


@wp.func
def sampled_light(scene: SceneData, table: LightTable, surface: Surface, index: int, pair: int, seed: int,
                  last: bool) -> wp.vec3:  # fmt: skip
    """An estimate of direct light that a Lambertian `surface` reflects [W/m²/sr], weighed against its bounce.

    last: no bounce follows.
    """
    pick = sobol_pair(index, pair, seed)
    place = sobol_pair(index, pair + 1, seed)
    sample = sample_light(scene, table, table.all_emitters, surface.position, pick.a, place)
    cosine = wp.dot(surface.geometric_normal, sample.direction)
    if cosine <= 0.0 or largest(sample.irradiance) <= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    if not connected(scene, surface.position, surface.geometric_normal, sample.point, sample.normal):
        return wp.vec3(0.0, 0.0, 0.0)
    light = wp.cw_mul(surface.albedo, sample.irradiance) * (cosine / PI)
    if last:
        return light
    return light / (1.0 + sample.solid_angle * cosine / PI)


@wp.func
def indirect_light(scene: SceneData, table: LightTable, first: Surface, paths: PathSamples, index: int,
                   seed: int) -> wp.vec3:  # fmt: skip
    """An estimate of the light that `first` reflects after 1 to `paths.bounces` other surfaces did [W/m²/sr]."""
    light = wp.vec3(0.0, 0.0, 0.0)
    throughput = wp.vec3(1.0, 1.0, 1.0)
    surface = first
    for bounce in range(paths.bounces):
        pair = FIRST_PAIR + PAIRS_A_BOUNCE * bounce
        bounce_sample = sobol_pair(index, pair, seed)
        direction = cosine_direction(surface.normal, bounce_sample.x, bounce_sample.y)
        if wp.dot(direction, surface.geometric_normal) <= 0.0:
            return light
        throughput = wp.cw_mul(throughput, surface.albedo)
        if bounce >= paths.roulette_bounce:
            survival = wp.min(largest(throughput), 1.0)
            if sobol_pair(index, pair + 3, seed).x >= survival:
                return light
            throughput = throughput / survival
        origin = offset_origin(surface.position, surface.geometric_normal, direction)
        hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        if bounce > 0:
            found = light_at_hit(scene, table, table.all_emitters, origin, direction, hit)
            density = wp.dot(direction, surface.normal) / PI
            light += wp.cw_mul(throughput, found.radiance) * (density / (density + found.density))
        if hit.face == NO_HIT:
            return light
        surface = surface_at(scene, hit, direction)
        surface.normal = surface.geometric_normal
        last = bounce == paths.bounces - 1
        light += wp.cw_mul(throughput, sampled_light(scene, table, surface, index, pair + 1, seed, last))
    return light


@wp.kernel
def trace_paths_kernel(first: int, scene: SceneData, table: LightTable, cameras: wp.array[CameraData], image: ImageSize,
                       paths: PathSamples, mean: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: averages its paths with those that are in `mean` (pixel,) already, radiance [W/m²/sr].

    cameras: one element.
    """
    pixel = first + wp.tid()
    own_seed = pixel_seed(pixel, paths.seed)
    total = wp.vec3(0.0, 0.0, 0.0)
    for index in range(paths.before, paths.before + paths.count):
        ray = pixel_ray(cameras[0], pixel, image)
        hit = seen_hit(scene, ray.origin, ray.direction)
        if hit.face == NO_HIT:
            if paths.direct:
                total += background(scene, ray.origin, ray.direction)
            continue
        surface = surface_at(scene, hit, ray.direction)
        if paths.direct:
            total += surface.emission
            total += delta_light(scene, table, surface, -ray.direction)
            total += area_light(scene, table, surface, -ray.direction, index, 0, 1, own_seed)
        if paths.indirect and table.count > 0:
            total += indirect_light(scene, table, surface, paths, index, own_seed)
    before = wp.vec3(0.0, 0.0, 0.0)
    if paths.before > 0:
        before = mean[pixel]
    # A mean, unlike a sum, keeps its precision however many samples there are.
    mean[pixel] = before + (total - before * float(paths.count)) / float(paths.before + paths.count)


def trace_paths(scene: SceneData, table: LightTable, camera: wp.array, size: tuple[int, int], paths: PathSamples,
                mean: wp.array) -> None:  # fmt: skip
    """Average more paths into `mean`, (pixel,) vec3 of linear radiance [W/m²/sr].

    camera: (1,) CameraData; size: (width, height).
    """
    inputs = [scene, table, camera, image_size(size), paths, mean]
    launch(trace_paths_kernel, size[0] * size[1], inputs, mean.device, weight=paths.count)

"""Path tracing: the reference that other methods are compared with. The same surfaces and lights, no VPLs.

Light is scattered by the whole BSDF at every vertex (gpu.device_scene.scattering), BLEND surfaces and panes are met at
random. Emitters are sampled at every vertex; light that a bounce meets counts by the balance heuristic (Veach 1997,
9.2), all of it after a perfect mirror or clear glass.

Direct light of a path's first surface is not inlined: in one piece the kernel takes a GPU's compiler twice as long and
traces 1.1 to 1.25 times as fast. Functions that bounces call are: apart, each call copies the scene's struct, and paths
take 1.5 to 4.6 times as long.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.dispersion import ALL_COLOURS, disperses, drawn_channel, of_channel, refracting
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.glass import attenuated
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import meet, met_surface, transmittance
from gpu.device_scene.scattering import (
    choose_part,
    is_narrow,
    is_perfect,
    part_of,
    sample_scattering,
    scattered,
    scattering_density,
)
from gpu.device_scene.sides import ray_coverage
from gpu.device_scene.specialisation import LOOK, made_for, specialisation, surface_specialisation
from gpu.device_scene.surface import Surface, surface_at
from gpu.direct.direct_light import DIRECT_PAIRS, area_light, delta_light, samples_by_power
from gpu.gbuffer.camera_rays import CameraData, pixel_ray
from gpu.lights.background import background
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import pixel_seed, sobol_pair

PART_PAIR = wp.constant(int(DIRECT_PAIRS))
FIRST_PAIR = wp.constant(int(DIRECT_PAIRS) + 1)
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
def sampled_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, index: int, pair: int,
                  seed: int, last: bool) -> wp.vec3:  # fmt: skip
    """An estimate of direct light that the chosen part of `surface` sends to unit `view` [W/m²/sr], weighed against its
    bounce. last: no bounce follows.
    """
    none = wp.vec3(0.0, 0.0, 0.0)
    if table.count == 0 or is_perfect(surface):
        return none
    scene.coverage = ray_coverage(index, pair, seed)
    pick = sobol_pair(index, pair, seed)
    sample = sample_light(scene, table, table.all_emitters, surface.position, pick.a, sobol_pair(index, pair + 1, seed))
    if largest(sample.irradiance) <= 0.0:
        return none
    light = wp.cw_mul(scattered(surface, view, sample.direction), sample.irradiance)
    if largest(light) <= 0.0:
        return none
    facing = wp.dot(surface.geometric_normal, sample.direction) > 0.0
    side = wp.where(facing, surface.geometric_normal, -surface.geometric_normal)
    light = wp.cw_mul(light, transmittance(scene, surface.position, side, sample.point, sample.normal))
    if last:
        return light
    return light / (1.0 + scattering_density(surface, view, sample.direction) * sample.solid_angle)


@wp.func
def met_light(scene: SceneData, table: LightTable, origin: wp.vec3, direction: wp.vec3, hit: Hit, density: float,
              shown: bool) -> wp.vec3:  # fmt: skip
    """The light that a bounce along unit `direction` brings from what it `hit` [W/m²/sr], weighed against samples.

    density: the bounce's [1/sr], 0 for a perfect one; shown: the camera sees this through perfect ones alone, so also
    what is merely shown (unlit materials, a sky of triangles).
    """
    if shown:
        if hit.face == NO_HIT:
            return background(scene, origin, direction)
        return surface_at(scene, hit, direction).emission
    found = light_at_hit(scene, table, table.all_emitters, origin, direction, hit)
    if density == 0.0:
        return found.radiance
    return found.radiance * (density / (density + found.density))


@wp.func
def indirect_light(scene: SceneData, table: LightTable, first: Surface, first_view: wp.vec3, paths: PathSamples,
                   index: int, seed: int) -> wp.vec3:  # fmt: skip
    """An unbiased estimate of the light that `first` sends to unit `first_view` after 1 to `paths.bounces` other
    surfaces scattered it [W/m²/sr]; with `paths.direct` also what its glass and perfect mirrors show of emitters, for
    which gpu.direct.direct_light has no samples.

    index: the path's number, for its samples of `seed`. This is what a method may add to its own direct light, or
    compare its indirect light with: give it a surface of the G-buffer, whose parts that are not there are zero.
    """
    light = wp.vec3(0.0, 0.0, 0.0)
    throughput = wp.vec3(1.0, 1.0, 1.0)
    absorption = wp.vec3(0.0, 0.0, 0.0)
    surface = first
    view = first_view
    shown = bool(True)
    channel = int(ALL_COLOURS)
    bounces = wp.where(paths.indirect, paths.bounces, 0)
    for bounce in range(bounces + 1):
        pair = FIRST_PAIR + PAIRS_A_BOUNCE * bounce
        pick = sobol_pair(index, pair + 3, seed)
        chosen = choose_part(surface, view, pick.y)
        surface = part_of(surface, chosen)
        if scene.dispersive and disperses(surface):
            if channel == ALL_COLOURS:
                channel = drawn_channel(sobol_pair(index, PART_PAIR, seed).y)
                throughput = of_channel(throughput, channel)
            surface = refracting(surface, channel)
        last = bounce == bounces and not is_narrow(surface)
        wanted = paths.indirect
        if bounce == 0:
            # Of what reflects here, direct light has samples of its own.
            wanted = paths.direct and (surface.glass > 0.0 or surface.mirror)
        if wanted and (bounce > 0 or surface.glass > 0.0):
            light += wp.cw_mul(throughput, sampled_light(scene, table, surface, view, index, pair + 1, seed, last))
        if last:
            return light
        place = sobol_pair(index, pair, seed)
        sample = sample_scattering(surface, view, chosen.rest, place.x, place.y)
        throughput = wp.cw_mul(throughput, sample.weight)
        survival = float(1.0)
        if bounce >= paths.roulette_bounce:
            survival = wp.min(largest(throughput), 1.0)
        if largest(throughput) <= 0.0 or pick.x >= survival:
            return light
        throughput = throughput / survival
        shown = shown and sample.density == 0.0
        if wp.dot(sample.direction, surface.geometric_normal) < 0.0 and not surface.thin:
            absorption = surface.absorption
        scene.coverage = ray_coverage(index, pair, seed)
        origin = offset_origin(surface.position, surface.geometric_normal, sample.direction)
        met = meet(scene, origin, sample.direction, False)
        throughput = wp.cw_mul(throughput, met.tint)
        if met.hit.face != NO_HIT:
            throughput = wp.cw_mul(throughput, attenuated(absorption, met.hit.t))
        if wanted:
            found = met_light(scene, table, origin, sample.direction, met.hit, sample.density, shown)
            light += wp.cw_mul(throughput, found)
        if met.hit.face == NO_HIT:
            return light
        surface = next_surface(scene, met.hit, sample.direction)
        view = -sample.direction
    return light


@wp.func
def next_surface(scene: SceneData, hit: Hit, direction: wp.vec3) -> Surface:
    """The surface at a `hit` along unit `direction`."""
    return met_surface(scene, hit, direction)


def path_light_of(features: SceneFeatures) -> wp.Function:
    """`path_light` for scenes of these `features`."""
    known = surface_specialisation(features)

    @wp.func(inline=False)
    def direct_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, index: int,
                     seed: int) -> wp.vec3:  # fmt: skip
        """An estimate of the direct light that `surface` sends to unit `view` [W/m²/sr], but for what glass shows."""
        surface = known(surface)
        light = delta_light(scene, table, surface, view)
        return light + area_light(scene, table, surface, view, samples_by_power(index, 0, 1, seed))

    @wp.func
    def path_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, paths: PathSamples, index: int,
                   seed: int) -> wp.vec3:  # fmt: skip
        """An estimate of the wanted light that `surface` sends to unit `view` [W/m²/sr]."""
        light = wp.vec3(0.0, 0.0, 0.0)
        surface = part_of(surface, choose_part(surface, view, sobol_pair(index, PART_PAIR, seed).x))
        perfect = surface.glass > 0.0 or surface.mirror
        if paths.direct:
            light += surface.emission
            if not perfect:
                light += direct_light(scene, table, surface, view, index, seed)
        if (paths.indirect and table.count > 0) or perfect:
            light += indirect_light(scene, table, surface, view, paths, index, seed)
        return light

    return path_light


@made_for(*LOOK, "glass", "panes", "environment", "dispersion")
def path_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise, path_light = specialisation(features), path_light_of(features)

    @wp.kernel(module="unique")
    def trace_paths_kernel(
        first: int,
        scene: SceneData,
        table: LightTable,
        cameras: wp.array[CameraData],
        image: ImageSize,
        paths: PathSamples,
        mean: wp.array[wp.vec3],
    ) -> None:
        """One thread a pixel: averages its paths with those that are in `mean` (pixel,) already, radiance [W/m²/sr].

        cameras: one element.
        """
        pixel = first + wp.tid()
        scene = specialise(scene)
        own_seed = pixel_seed(pixel, paths.seed)
        total = wp.vec3(0.0, 0.0, 0.0)
        for index in range(paths.before, paths.before + paths.count):
            ray = pixel_ray(cameras[0], pixel, image)
            scene.coverage = ray_coverage(index, PART_PAIR, own_seed)
            met = meet(scene, ray.origin, ray.direction, scene.one_sided)
            if met.hit.face == NO_HIT:
                if paths.direct:
                    total += wp.cw_mul(met.tint, background(scene, ray.origin, ray.direction))
                continue
            surface = next_surface(scene, met.hit, ray.direction)
            total += wp.cw_mul(met.tint, path_light(scene, table, surface, -ray.direction, paths, index, own_seed))
        before = wp.vec3(0.0, 0.0, 0.0)
        if paths.before > 0:
            before = mean[pixel]
        # A mean, unlike a sum, keeps its precision however many samples there are.
        mean[pixel] = before + (total - before * float(paths.count)) / float(paths.before + paths.count)

    return trace_paths_kernel


def trace_paths(scene: SceneData, table: LightTable, camera: wp.array, size: tuple[int, int], paths: PathSamples,
                mean: wp.array, features: SceneFeatures = EVERYTHING) -> None:  # fmt: skip
    """Average more paths into `mean`, (pixel,) vec3 of linear radiance [W/m²/sr].

    camera: (1,) CameraData; size: (width, height).
    """
    inputs = [scene, table, camera, image_size(size), paths, mean]
    kernel = path_kernel(features)
    launch(kernel, size[0] * size[1], inputs, mean.device, weight=paths.count)

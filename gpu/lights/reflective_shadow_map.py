"""Reflective shadow maps: what a light sees, a VPL a pixel (C. Dachsbacher and M. Stamminger 2005), by rays.

Each map is of a punctual light, of the sky, or of a patch of emissive triangles, whose pixels each have a point of the
patch as their light's place. Pixels are in Morton's order, map after map: together they are an image, the atlas, the
maps of which lie in Morton's order, too, and what lies beyond the last is empty. All is traced from the table of lights
as it is now.
"""

import numpy as np
import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import launch
from gpu.core.morton import pixel_of_morton_2d
from gpu.device_scene.bsdf import is_translucent, largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import SIDE_PAIR, matt_side, spread_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.sides import ray_coverage
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import probabilities
from gpu.lights.emission import Particle, emit, sun_particle
from gpu.lights.light_chain import Flight, unscattered
from gpu.lights.light_paths import Vpls
from gpu.lights.light_table import DIRECTIONAL, LightTable, PowerCdf, choose_emitter, is_light, is_triangle
from gpu.lights.path_light import unseen_suns
from gpu.lights.shadow_map_parameters import SHADOW_MAP_PARAMETERS, ShadowMapParameters
from gpu.lights.sun_map import image_place
from gpu.sampling.sobol import TO_UNIT, Pair, sobol_pair
from gpu.scene.types import Doubles, Ints

WHOLE = 1 << 32


@wp.struct
class ShadowMaps:
    """`count` maps of `side`² pixels each, a power of two.

    atlas_side: pixels along each side of the atlas, a power of two; first, width (map,): the values by which the
    table's choice among all emitters takes those of a map, and how many these are, of 2³²; halvings (map,): how often
    its sides are halved: just the first pixels / 4^halvings have rays, which are that smaller image; worth (map,): how
    much its light matters, 1, but less for a sun that lights nothing that cameras find.
    """

    count: int
    side: int
    atlas_side: int
    first: wp.array[wp.uint32]
    width: wp.array[wp.uint32]
    halvings: wp.array[int]
    worth: wp.array[float]


@made_for(*LOOK, "environment", "specular")
def shadow_map_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise, specular = specialisation(features), features.specular

    @wp.kernel(module="unique")
    def shadow_map_kernel(first: int, scene: SceneData, table: LightTable, maps: ShadowMaps, bounces: int, seed: int,
                          out: Vpls) -> None:  # fmt: skip
        """One thread a pixel of the maps: the VPL where its ray ends, after `bounces` mirrors and glass at most, of
        flux 0 where it meets nothing.

        A pixel is a part of the directions of a light with a place or a patch, and of the disk through which others
        light the scene; what else a ray depends on is drawn by `seed`, and so is its place in the pixel.
        """
        pixel = first + wp.tid()
        scene = specialise(scene)
        out.flux[pixel] = wp.vec3(0.0, 0.0, 0.0)
        pixels = maps.side * maps.side
        number_of_map = pixel // pixels
        halvings = maps.halvings[number_of_map]
        rays = pixels >> (2 * halvings)
        ray = pixel % pixels
        if ray >= rays:
            return
        width = maps.width[number_of_map]
        drawn = sobol_pair(pixel, 0, seed)
        pick = maps.first[number_of_map] + wp.uint32((wp.uint64(drawn.a) * wp.uint64(width)) >> wp.uint64(32))
        place = pixel_of_morton_2d(ray)
        jitter = sobol_pair(pixel, 1, seed)
        side = float(maps.side >> halvings)
        within = Pair()
        within.x = (float(place[0]) + jitter.x) / side
        within.y = (float(place[1]) + jitter.y) / side
        other = sobol_pair(pixel, 2, seed)
        choice = choose_emitter(table.all_emitters, pick)
        number = choice.index - table.triangle_count - table.sky_count
        particle = Particle()
        if is_light(table, choice.index):
            light = table.lights[number]
            if light.kind == DIRECTIONAL:
                place_of_ray = image_place(table.suns, number, within)
                particle = sun_particle(table, light, place_of_ray, choice.probability)
            else:
                particle = emit(scene, table, pick, other, within)
        elif is_triangle(table, choice.index):
            particle = emit(scene, table, pick, other, within)
        else:
            particle = emit(scene, table, pick, within, other)
        direction = particle.direction
        origin = offset_origin(particle.origin, particle.normal, direction)
        if wp.static(specular):
            flight = Flight()
            flight.origin = origin
            flight.direction = direction
            flight.flux = particle.flux
            chain = unscattered(scene, flight, pixel, 3, bounces, seed)
            particle.flux = chain.flight.flux
            if largest(particle.flux) <= 0.0:
                return
            origin = chain.flight.origin
            direction = chain.flight.direction
            scene.coverage = ray_coverage(pixel, chain.bounce, seed)  # by which `unscattered` came here
        hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        if hit.face == NO_HIT:
            return
        surface = met_at(scene, hit, direction)
        if scene.part_glass:
            surface.glass = 0.0  # as `unscattered` has chosen
        if is_translucent(surface):
            surface = matt_side(surface, -direction, 1.0, sobol_pair(pixel, SIDE_PAIR, seed).x)
        share = float(width) * TO_UNIT / float(rays)
        out.position[pixel] = surface.position
        out.normal[pixel] = surface.geometric_normal
        out.flux[pixel] = wp.cw_mul(particle.flux, spread_reflectance(surface, -direction, 1.0)) * share

    return shadow_map_kernel


def trace_shadow_maps(scene: SceneData, table: LightTable, maps: ShadowMaps, bounces: int, seed: int,
                      features: SceneFeatures, out: Vpls) -> None:  # fmt: skip
    """Trace all `maps` of the lights in `table` into `out`, a VPL a pixel; none of them leaves the device."""
    inputs = [scene, table, maps, bounces, seed, out]
    kernel = shadow_map_kernel(features)
    launch(kernel, out.count, inputs, out.flux.device)


def map_of_emitters(ends: Doubles, faces: Doubles, chosen: ShadowMapParameters = SHADOW_MAP_PARAMETERS) -> Ints:
    """The map of each emitter, ascending from 0.

    ends (emitter,): of their shares of all power, ascending to 1; faces (triangle, 6): centres and normals of the first
    emitters, the emissive triangles.
    """
    begins = np.ones(len(ends), bool)
    apart = np.linalg.norm(np.diff(faces[:, :3], axis=0), axis=1) > chosen.widest
    turned = (faces[1:, 3:] * faces[:-1, 3:]).sum(axis=1) < chosen.least_cosine
    begins[1 : len(faces)] = apart | turned
    groups = np.cumsum(begins) - 1
    if groups[-1] >= chosen.most_maps:
        starts = np.append(0.0, ends)[np.flatnonzero(begins)]
        shared = np.floor(starts * chosen.most_maps).astype(np.int64)
        groups = np.unique(shared, return_inverse=True)[1][groups]
    return groups.astype(np.int32)


def halvings_of(widths: Doubles, side: int, chosen: ShadowMapParameters = SHADOW_MAP_PARAMETERS) -> Ints:
    """How often the sides of maps of `side`² pixels are halved, (map,), by their `widths`, as of ShadowMaps."""
    fewer = np.floor(np.log(widths.max() / np.maximum(widths, 1.0)) / np.log(4.0))
    return np.minimum(fewer, np.log2(side / chosen.least_side)).astype(np.int32)


def make_shadow_maps(device_scene: DeviceScene, table: LightTable, by_power: PowerCdf, side: int,
                     chosen: ShadowMapParameters = SHADOW_MAP_PARAMETERS) -> ShadowMaps:  # fmt: skip
    """The maps of the emitters in `table`, of which there is one or more, of `side`² pixels each.

    by_power: the choice among them by their power alone.
    """
    scene, device = device_scene.scene, device_scene.device
    triangles = scene.triangles[device_scene.triangle_order[table.faces.numpy()[: table.triangle_count]]]
    corners = scene.vertices[triangles].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    cumulative = table.all_emitters.cumulative.numpy().astype(np.int64)
    cumulative[-1] = WHOLE
    groups = map_of_emitters(cumulative / WHOLE, np.hstack([corners.mean(axis=1), normals]), chosen)
    last = cumulative[np.append(np.flatnonzero(np.diff(groups)), len(groups) - 1)]
    first = np.append(0, last[:-1])
    # One that has all values loses the last of them: 2³² is no 32-bit number.
    width = np.minimum(last - first, WHOLE - 1)
    unseen = np.bincount(groups, ~unseen_suns(table)) == 0
    worth = np.ones(len(first))
    if unseen.any() and not unseen.all():
        reach, power = (np.bincount(groups, probabilities(each)) for each in (table.all_emitters, by_power))
        least = 1.0 / WHOLE
        now, by_itself = (each[unseen].sum() / max(each[~unseen].sum(), least) for each in (reach, power))
        worth[unseen] = min(now / max(by_itself, least), 1.0)
    maps = ShadowMaps()
    maps.count, maps.side, maps.atlas_side = len(first), side, side
    while (maps.atlas_side // side) ** 2 < maps.count:
        maps.atlas_side *= 2
    maps.first = wp.array(first.astype(np.uint32), dtype=wp.uint32, device=device)
    maps.width = wp.array(width.astype(np.uint32), dtype=wp.uint32, device=device)
    maps.halvings = wp.array(halvings_of(width.astype(np.float64), side, chosen), dtype=int, device=device)
    maps.worth = wp.array(worth, dtype=float, device=device)
    return maps

"""Gather rays that end where nothing tells of light, on small things and beside walls: they go on as paths do, to the
emitters and to where light is known.

One ray in five to eight ends so. Estimates of the density of photons are no use there: photons are few, and of what
they are spread over little is known.

One path in five goes on from its second vertex. Those are followed by threads of their own, side by side, from where
the gather ray ends, but for what that vertex told: among the others each of them would have a GPU's whole warp wait.
"""

from dataclasses import dataclass
from typing import Any

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import RAY_REGISTERS
from gpu.core.parameters import parameters
from gpu.device_scene.bsdf import is_translucent, largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import SIDE_PAIR, even_reflectance, matt_side, spread_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint, stops_at_pane, transmittance
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.indirect.bright_photons import BrightPhotons, any_bright, ray_share
from gpu.indirect.gather_rays import RayEnds, gather_direction, gather_tint
from gpu.indirect.guided_rays import GUIDED_PAIR, guided_ray
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.sp.centres import ShadingClusters

# The sequences of Sobol points of a path: the first is of the gather rays.
FIRST_PAIR = wp.constant(1)
PAIRS_A_VERTEX = wp.constant(3)


@wp.struct
@dataclass
class OnwardParameters:
    """vertices: of a path at the most, with the end of the gather ray; where nothing is known still, it is dark.

    Of light that is known a path counts what is not of the last bounce: it adds one itself.
    """

    vertices: int = 4


ONWARD_PARAMETERS: OnwardParameters = parameters(OnwardParameters)


@wp.struct
class Onward:
    """What paths find besides light that is known. table: of the emitters; bright: photons; bounces: at most, as
    photons have; begin, end: the vertices that are looked at, from the first to before the last.
    """

    chosen: OnwardParameters
    table: LightTable
    bright: BrightPhotons
    bounces: int
    begin: int
    end: int


def onward(table: LightTable, bright: BrightPhotons, bounces: int, begin: int, end: int) -> Onward:
    """What the vertices of paths from `begin` to before `end` find of the emitters of `table` and `bright` photons."""
    part = Onward()
    part.chosen, part.table, part.bounces = ONWARD_PARAMETERS, table, bounces
    part.bright, part.begin, part.end = bright, begin, end
    return part


@wp.func
def emitted_irradiance(scene: SceneData, table: LightTable, surface: Surface, number: int, pair: int,
                       seed: int) -> wp.vec3:  # fmt: skip
    """Irradiance by a sample of the emitters [W/m²], weighed against a cosine-distributed ray."""
    if table.count == 0:
        return wp.vec3(0.0, 0.0, 0.0)
    pick = sobol_pair(number, pair, seed)
    place = sobol_pair(number, pair + 1, seed)
    sample = sample_light(scene, table, table.all_emitters, surface.position, pick.a, place)
    cosine = wp.dot(sample.direction, surface.geometric_normal)
    if cosine <= 0.0 or largest(sample.irradiance) <= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    reached = transmittance(scene, surface.position, surface.geometric_normal, sample.point, sample.normal)
    share = 1.0 / (1.0 + cosine / PI * sample.solid_angle)
    return wp.cw_mul(sample.irradiance, reached) * (cosine * share)


@made_for(*LOOK, "environment", "panes")
def onward_kernel(features: SceneFeatures, lookup: wp.Function, data: Any) -> wp.Kernel:
    """The kernel for scenes of these `features`; lookup, data: as of gpu.indirect.illumination.Illumination."""
    specialise, guided = specialisation(features), guided_ray(lookup, data)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def onward_kernel(first: int, scene: SceneData, part: Onward, lit: data, clusters: ShadingClusters,
                      order: wp.array[int], seeds: wp.array[int], ends: RayEnds,
                      radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
        """One thread a ray that is listed: adds what a `part` of one path tells to its `radiance` (cluster · rays,)
        [W/m²/sr]; `unknown` of the ray: whether the path goes on. order, seeds: as of gather_direction.
        """
        entry = first + wp.tid()
        if entry >= ends.totals[ends.totals.shape[0] - 1]:
            return
        scene = specialise(scene)
        index = ends.listed[entry]
        rays = order.shape[0]
        number = order[index % rays]
        seed = pixel_seed(index // rays, seeds[0])
        direction = gather_direction(clusters, order, seeds, index // rays, index % rays)
        surface = met_at(scene, ends.hits[index], direction)
        if is_translucent(surface):
            surface = matt_side(surface, -direction, 1.0, sobol_pair(number, SIDE_PAIR, seed).x)
        throughput = even_reflectance(surface, -direction) / PI
        # Of light from emitters: caustics have the rest.
        spread = spread_reflectance(surface, -direction, 1.0) / PI
        tint = wp.vec3(1.0, 1.0, 1.0)
        if scene.part_glass:
            tint = gather_tint(scene, clusters, ends.hits[index], direction, index // rays)
            throughput = wp.cw_mul(throughput, tint)
            spread = wp.cw_mul(spread, tint)
        light = radiance[index]
        ends.unknown[index] = 0
        vertices = wp.min(part.chosen.vertices, part.bounces)
        for vertex in range(wp.min(part.end, vertices)):
            pair = FIRST_PAIR + PAIRS_A_VERTEX * vertex
            if vertex >= part.begin:
                found = emitted_irradiance(scene, part.table, surface, number, pair, seed)
                light += wp.cw_mul(spread, found)
            place = sobol_pair(number, pair + 2, seed)
            normal = surface.geometric_normal
            direction = cosine_direction(normal, place.x, place.y)
            origin = offset_origin(surface.position, normal, direction)
            hit = closest_hit(scene, origin, direction, RAY_LENGTH)
            if scene.part_glass:
                tint = crossed_tint(scene, origin, direction, hit.t, False)
                spread = wp.cw_mul(spread, tint)
            if vertex >= part.begin:
                met = light_at_hit(scene, part.table, part.table.all_emitters, origin, direction, hit)
                density = wp.dot(direction, normal) / PI
                if largest(met.radiance) > 0.0 and not stops_at_pane(scene, origin, direction, hit.t):
                    light += wp.cw_mul(spread, met.radiance) * (PI * density / wp.max(density + met.density, 1.0e-20))
            if vertex + 1 == vertices:
                break
            if vertex >= part.begin and any_bright(part.bright) > 0:
                value = sobol_pair(number, GUIDED_PAIR + 1 + vertex, seed).a
                bright = guided(scene, lit, part.bright, surface.position, normal, normal, value, 1.0)
                light += wp.cw_mul(throughput, bright.earlier) * PI
            if hit.face == NO_HIT:
                break
            if scene.part_glass:
                throughput = wp.cw_mul(throughput, tint)
            way = -surface.position
            surface = met_at(scene, hit, direction)
            way += surface.position
            if vertex >= part.begin:
                estimate = lookup(lit, surface.position, surface.geometric_normal)
                if estimate.known:
                    share = ray_share(part.bright, estimate.irradiance, way, normal, surface.geometric_normal, 1.0)
                    reflected = wp.cw_mul(throughput, even_reflectance(surface, -direction))
                    light += wp.cw_mul(reflected, estimate.earlier) * share
                    break
                if vertex + 1 == part.end:
                    ends.unknown[index] = 1
            if is_translucent(surface):
                surface = matt_side(surface, -direction, 1.0, sobol_pair(number, SIDE_PAIR + 1 + vertex, seed).x)
            spread = wp.cw_mul(throughput, spread_reflectance(surface, -direction, 1.0))
            throughput = wp.cw_mul(throughput, even_reflectance(surface, -direction))
        radiance[index] = light

    return onward_kernel

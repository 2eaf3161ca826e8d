"""Radiosity at VPLs of narrow surfaces, told by rays: of how densely VPLs lie, the few there tell little.

A fifth to a half of a room's near-field light comes from these: frames, edges of shelves, mouldings.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import launch
from gpu.core.intrinsics import lanes_of, vector_sum
from gpu.core.parameters import parameters
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.panes import transmittance
from gpu.device_scene.rays import blocking, closest_hit, lifted
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.vpl.radiosity_cache import RadiosityCache, places_covered, vpl_around
from gpu.vpl.radiosity_reach import is_apart_of
from gpu.vpl.vpl_reflectance import reflectance_at

GATHER_SEED = wp.constant(0x2E5B)


@wp.struct
@dataclass
class GatherParameters:
    """least_vpls: of a light set. Of fewer, disks are wide, and what a point of one has is not what all of it has,
    above all where the sun makes patches. samples: of the emitters, and as many rays for what surfaces send; rounds: of
    these rays, so that light goes so often from one narrow surface to the next; radius_share: VPLs that answer for
    where rays end have radii of about this share of their length; clearance: as of gpu.vpl.radiosity_reach.
    """

    least_vpls: int = 65_536
    samples: int = 8
    rounds: int = 2
    radius_share: float = 0.06
    clearance: float = 0.1


GATHER_PARAMETERS: GatherParameters = parameters(GatherParameters)


@wp.func
def is_gathered(lit: RadiosityCache, covered: wp.array[int], vpl: int) -> bool:
    """Whether so few places around a VPL are surface that its radiosity is gathered.

    covered: as of gpu.vpl.radiosity_cache.disk_coverage_kernel.
    """
    return lit.radius[vpl] > 0.0 and places_covered(covered, vpl) < lit.chosen.least_covered


@made_for(*LOOK)
def ray_ends_kernel(features: SceneFeatures, blocked: wp.Function) -> wp.Kernel:
    """The kernel for scenes of these `features`; blocked: as of is_apart_of."""
    specialise, is_apart = specialisation(features), is_apart_of(blocked)

    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def ray_ends_kernel(first: int, lanes: int, scene: SceneData, covered: wp.array[int], chosen: GatherParameters,
                        lit: RadiosityCache, reflectance: wp.array[wp.vec3], spread: wp.array[wp.vec3],
                        ends: wp.array[int]) -> None:  # fmt: skip
        """`lanes` threads a VPL: where it is gathered, the reflectance of its surface, without what caustics have of
        light from emitters in `spread`, and for each ray the VPL that answers for where it ends, −1 for none: ends
        (vpl, sample), flattened.
        """
        index = first + wp.tid()
        vpl = index // lanes
        lane = index % lanes
        if not is_gathered(lit, covered, vpl):
            return
        scene = specialise(scene)
        normal = lit.normal[vpl]
        if lane == 0:
            surface = reflectance_at(scene, lit.position[vpl], normal)
            reflectance[vpl] = surface.even
            spread[vpl] = surface.spread
        origin = lifted(lit.position[vpl], normal)
        seed = pixel_seed(vpl, GATHER_SEED)
        for number in range(lane, chosen.samples, lanes):
            place = sobol_pair(number, 2, seed)
            direction = cosine_direction(normal, place.x, place.y)
            other = int(-1)
            hit = closest_hit(scene, origin, direction, RAY_LENGTH)
            if hit.face != NO_HIT:
                side = triangle_normal(scene, hit.face)
                side = wp.where(wp.dot(side, direction) < 0.0, side, -side)
                end = origin + direction * hit.t
                found = vpl_around(lit, end, side, chosen.radius_share * hit.t)
                if found >= 0:
                    apart = is_apart(scene, end, side, origin, lit.position[found], chosen.clearance)
                    other = wp.where(apart, -1, found)
            ends[vpl * chosen.samples + number] = other

    return ray_ends_kernel


@made_for(*LOOK, "environment")
def emitters_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def emitters_kernel(first: int, lanes: int, scene: SceneData, table: LightTable, covered: wp.array[int],
                        chosen: GatherParameters, reflectance: wp.array[wp.vec3], spread: wp.array[wp.vec3],
                        lit: RadiosityCache) -> None:  # fmt: skip
        """`lanes` threads a VPL: where it is gathered, its radiosity is what it reflects of emitters [W/m²]."""
        index = first + wp.tid()
        vpl = index // lanes
        lane = index % lanes
        if not is_gathered(lit, covered, vpl):
            return
        scene = specialise(scene)
        if largest(reflectance[vpl]) <= 0.0:  # glass, which lets through what is not gathered here
            return
        position = lit.position[vpl]
        normal = lit.normal[vpl]
        seed = pixel_seed(vpl, GATHER_SEED)
        irradiance = wp.vec3(0.0, 0.0, 0.0)
        for number in range(lane, chosen.samples, lanes):
            pick = sobol_pair(number, 0, seed)
            place = sobol_pair(number, 1, seed)
            sample = sample_light(scene, table, table.all_emitters, position, pick.a, place)
            cosine = wp.dot(sample.direction, normal)
            if cosine > 0.0:
                reached = transmittance(scene, position, normal, sample.point, sample.normal)
                irradiance += wp.cw_mul(sample.irradiance, reached) * cosine
        irradiance = vector_sum(irradiance, lanes)
        if lane == 0:
            lit.radiosity[vpl] = wp.cw_mul(spread[vpl], irradiance) / float(chosen.samples)

    return emitters_kernel


@wp.kernel
def surfaces_kernel(first: int, lanes: int, covered: wp.array[int], chosen: GatherParameters, ends: wp.array[int],
                    reflectance: wp.array[wp.vec3], lit: RadiosityCache, emitted: wp.array[wp.vec3],
                    radiosity: wp.array[wp.vec3]) -> None:  # fmt: skip
    """`lanes` threads a VPL: adds to `emitted` what it reflects of other surfaces, where that is gathered.

    ends: as of ray_ends_kernel; emitted, radiosity (vpl,) [W/m²]: without and with that; the others' is in `lit`.
    """
    index = first + wp.tid()
    vpl = index // lanes
    lane = index % lanes
    if lane == 0:
        radiosity[vpl] = emitted[vpl]
    if not is_gathered(lit, covered, vpl):
        return
    irradiance = wp.vec3(0.0, 0.0, 0.0)
    for number in range(lane, chosen.samples, lanes):
        other = ends[vpl * chosen.samples + number]
        if other >= 0:
            irradiance += lit.radiosity[other]
    irradiance = vector_sum(irradiance, lanes)
    if lane == 0:
        radiosity[vpl] += wp.cw_mul(reflectance[vpl], irradiance) / float(chosen.samples)


class RadiosityGather:
    """Gathers the radiosity at up to `room` VPLs of `scene` on narrow surfaces; arrays are allocated once.

    table: of the scene's emitters; features: the scene's; bounces: with one, VPLs have no light but that of emitters.
    With more, what they gather has one bounce too many.
    """

    def __init__(self, scene: SceneData, table: LightTable, features: SceneFeatures, bounces: int, room: int,
                 device: wp.Device, chosen: GatherParameters = GATHER_PARAMETERS) -> None:  # fmt: skip
        self._ray_ends = ray_ends_kernel(features, blocking(scene))
        self._emitters = emitters_kernel(features)
        self._scene, self._table, self._chosen, self.device = scene, table, chosen, device
        self._rounds = chosen.rounds if bounces > 1 else 0
        self._emitted, self._gathered, self._reflectance, self._spread = (
            wp.zeros(room, dtype=wp.vec3, device=device) for _ in range(4)
        )
        self._ends = wp.zeros(room * chosen.samples, dtype=int, device=device)

    def run(self, lit: RadiosityCache, covered: wp.array) -> None:
        """Have it in `lit`; covered: as of disk_coverage_kernel."""
        lanes, threads = self._threads(lit)
        inputs = [lanes, self._scene, covered, self._chosen, lit, self._reflectance, self._spread, self._ends]
        launch(self._ray_ends, threads, inputs, self.device)
        self.relight(lit, covered)

    def relight(self, lit: RadiosityCache, covered: wp.array) -> None:
        """As `run`, where nothing but light has changed since."""
        chosen, device = self._chosen, self.device
        lanes, threads = self._threads(lit)
        inputs = [lanes, self._scene, self._table, covered, chosen, self._reflectance, self._spread, lit]
        launch(self._emitters, threads, inputs, device)
        wp.copy(self._emitted, lit.radiosity)
        inputs = [lanes, covered, chosen, self._ends, self._reflectance, lit, self._emitted, self._gathered]
        for _ in range(self._rounds):
            launch(surfaces_kernel, threads, inputs, device)
            wp.copy(lit.radiosity, self._gathered)

    def _threads(self, lit: RadiosityCache) -> tuple[int, int]:
        """Lanes of a VPL, as one in ten is gathered, and all threads."""
        lanes = lanes_of(self.device, few=True)
        return lanes, lanes * len(lit.radius)

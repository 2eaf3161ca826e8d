"""Bias compensation: paths for the light that bounded VPLs leave out, so that both are right in the mean.

Of the light that one surface sends another, a VPL's bound takes the share A/(π·d² + A) away. A path gives it back:
where it arrives, emitters are sampled, and where it did not go far, VPLs, too, which are bounded likewise, and it goes
on (T. Kollig and A. Keller, Illumination in the Presence of Weak Singularities, 2004).
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, launch
from gpu.core.parameters import parameters
from gpu.correction.vpl_connections import CONNECTION_PARAMETERS
from gpu.device_scene.bsdf import is_translucent, largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import SIDE_PAIR, even_reflectance, matt_side, over_even, spread_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint, tint_between
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit, connected
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.direct.direct_light import delta_light, ris_light, samples_by_power
from gpu.direct.path_tracing import FIRST_PAIR, PAIRS_A_BOUNCE
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.received_lobes import received_by_lobe
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import hashed, pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.vpl.bound_area import BoundAreas, bound_area
from gpu.vpl.form_factor import light_of, member_irradiance
from gpu.vpl.group_sampling import Reservoir, offered, reservoir
from gpu.vpl.vpl_clusters import VplClusters
from gpu.vpl.vpl_lobes import LEAST_ROUGHNESS, VplLobes, by_lobe, sends_by_lobe

VPL_KEY = wp.constant(wp.uint32(0x1B56C4E9))


@wp.struct
@dataclass
class BiasCompensationParameters:
    """How many paths go on and what they look at.

    wider: a path goes on from where it arrived with so many times the share that a bound takes away; fewer would count
    for so much that single ones were seen. VPLs there, one of as many candidates as a connection has
    (gpu.correction.vpl_connections), have bounds of so many times the area: those near by would be rare and bright.
    """

    wider: float = 16.0


BIAS_COMPENSATION_PARAMETERS: BiasCompensationParameters = parameters(BiasCompensationParameters)


@wp.struct
class CompensationPaths:
    """One path of each SP. bounds: tell A anywhere; areas (vpl,): A of VPLs; lobes: of VPLs; bounces: the most surfaces
    that light meets before an SP; sample: the path's number among those of the SP; seed: of all of these.
    """

    bounds: BoundAreas
    areas: wp.array[float]
    lobes: VplLobes
    bounces: int
    sample: int
    seed: int


@wp.func
def seen_vpl(scene: SceneData, surface: Surface, vpls: VplClusters, paths: CompensationPaths, last_bounce: int,
             state: wp.uint32, chosen: BiasCompensationParameters) -> Reservoir:  # fmt: skip
    """One of the bounded VPLs of at most `last_bounce`, drawn by the irradiance that it sends `surface`; no item where
    a shadow ray finds it hidden.
    """
    members = vpls.members
    candidates = wp.static(CONNECTION_PARAMETERS.candidates)
    drawn = reservoir(state)
    for candidate in range(candidates):
        vpl = int(hashed(state + wp.uint32(candidate)) % wp.uint32(members.count))
        if members.bounce[vpl] <= last_bounce:
            area = paths.areas[vpl] * chosen.wider
            light = member_irradiance(surface.position, surface.geometric_normal, vpls, vpl, area)
            if brightness(light) > 0.0:
                drawn = offered(drawn, vpl, brightness(light))
    if drawn.item >= 0:
        position = members.position[drawn.item]
        normal = members.normal[drawn.item]
        if not connected(scene, surface.position, surface.geometric_normal, position, normal):
            drawn.item = -1
    return drawn


@wp.func
def vpl_light(surface: Surface, view: wp.vec3, even: wp.vec3, vpls: VplClusters, lobes: VplLobes,
              drawn: Reservoir) -> wp.vec3:  # fmt: skip
    """An estimate of the irradiance at `surface` by VPLs, of which one is `drawn`: so much as if it reflected `even` of
    it, evenly, to unit `view`.
    """
    if drawn.item < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    candidates = float(wp.static(CONNECTION_PARAMETERS.candidates))
    light = light_of(vpls, drawn.item, drawn.total * float(vpls.members.count) / candidates)
    to_light = wp.normalize(vpls.members.position[drawn.item] - surface.position)
    light = wp.cw_mul(light, by_lobe(lobes, vpls.members, drawn.item, -to_light))
    if surface.f90 > 0.0:
        light = wp.cw_mul(light, over_even(surface, view, to_light, even))
    return light


@wp.func
def compensating_light(scene: SceneData, table: LightTable, gbuffer: GBuffer, pixel: int, vpls: VplClusters,
                       paths: CompensationPaths, seed: int,
                       chosen: BiasCompensationParameters) -> wp.vec3:  # fmt: skip
    """An estimate of the irradiance at the SP of a pixel that bounds of VPLs leave out, over π [W/m²/sr]."""
    light = wp.vec3(0.0, 0.0, 0.0)
    throughput = wp.vec3(1.0, 1.0, 1.0)
    reflectance = wp.vec3(1.0, 1.0, 1.0)
    view = wp.vec3(0.0, 0.0, 0.0)
    surface = Surface()
    surface.position = gbuffer.position[pixel]
    surface.geometric_normal = gbuffer.geometric_normal[pixel]
    surface.normal = gbuffer.normal[pixel]
    wider = float(1.0)
    for bounce in range(paths.bounces):
        pair = FIRST_PAIR + PAIRS_A_BOUNCE * bounce
        place = sobol_pair(paths.sample, pair, seed)
        direction = cosine_direction(surface.normal, place.x, place.y)
        if wp.dot(direction, surface.geometric_normal) <= 0.0:
            return light
        if bounce == 0:
            throughput = received_by_lobe(gbuffer, pixel, direction)
        elif surface.f90 > 0.0:
            throughput = wp.cw_mul(throughput, over_even(surface, view, direction, reflectance))
        origin = offset_origin(surface.position, surface.geometric_normal, direction)
        hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        if hit.face == NO_HIT:
            return light
        surface = met_at(scene, hit, direction)
        if scene.part_glass:
            throughput = wp.cw_mul(throughput, crossed_tint(scene, origin, direction, hit.t, False))
        surface.normal = surface.geometric_normal
        view = -direction
        area = wider * bound_area(paths.bounds, surface.position, surface.normal)
        if is_translucent(surface):
            surface = matt_side(surface, view, 1.0, sobol_pair(paths.sample, SIDE_PAIR + bounce, seed).x)
        reflectance = even_reflectance(surface, view)
        if paths.lobes.count > 0 and sends_by_lobe(surface):
            surface.roughness = wp.max(surface.roughness, LEAST_ROUGHNESS)
        else:
            # The rest of the light of emitters comes by caustics.
            surface.diffuse = spread_reflectance(surface, view, 1.0)
            surface.f90 = 0.0
            surface.sheen = wp.vec3(0.0, 0.0, 0.0)
        share = area / (PI * hit.t * hit.t + area)
        throughput = throughput * share
        light += wp.cw_mul(throughput, delta_light(scene, table, surface, view))
        if table.sampled.count > 0 and largest(reflectance) > 0.0:
            own = samples_by_power(paths.sample, 0, 1, seed + bounce + 1)
            found = ris_light(scene, table, surface, view, own, 0, False)
            light += wp.cw_mul(throughput, found)
        survival = wp.min(chosen.wider * share, 1.0)
        if sobol_pair(paths.sample, pair + 3, seed).x >= survival:
            return light
        throughput = wp.cw_mul(throughput, reflectance) / survival
        state = hashed(wp.uint32(seed) ^ hashed(VPL_KEY + wp.uint32(paths.sample * paths.bounces + bounce)))
        wider = chosen.wider
        drawn = seen_vpl(scene, surface, vpls, paths, paths.bounces - 2 - bounce, state, chosen)
        sent = vpl_light(surface, view, reflectance, vpls, paths.lobes, drawn)
        if scene.part_glass and drawn.item >= 0:
            position = vpls.members.position[drawn.item]
            normal = vpls.members.normal[drawn.item]
            sent = wp.cw_mul(sent, tint_between(scene, surface.position, surface.normal, position, normal))
        light += wp.cw_mul(throughput, sent) / PI
    return light


@made_for(*LOOK, "glass", "panes", "environment")
def bias_compensation_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    # As for direct light, whose candidates are looked at here, too.
    options = {"max_unroll": 1, "fast_math": True}

    @wp.kernel(module="unique", module_options=options, cuda_max_registers=RAY_REGISTERS)
    def bias_compensation_kernel(first: int, scene: SceneData, table: LightTable, gbuffer: GBuffer, points: PointList,
                                 vpls: VplClusters, paths: CompensationPaths, chosen: BiasCompensationParameters,
                                 irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
        """One thread an SP: adds what its path finds to its irradiance [W/m²]."""
        sp = first + wp.tid()
        if sp >= points.count[0]:
            return
        scene = specialise(scene)
        pixel = points.pixels[sp]
        seed = pixel_seed(pixel, paths.seed)
        irradiance[pixel] += compensating_light(scene, table, gbuffer, pixel, vpls, paths, seed, chosen) * PI

    return bias_compensation_kernel


def compensate_bias(scene: SceneData, table: LightTable, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters,
                    paths: CompensationPaths, irradiance: wp.array, features: SceneFeatures) -> None:  # fmt: skip
    """Add to the `irradiance` (pixel,) of `sps` what bounds of `vpls` leave out, by a path each.

    table: of the scene's emitters, which are sampled wherever a path arrives.
    """
    inputs = [scene, table, gbuffer, sps.points, vpls, paths, BIAS_COMPENSATION_PARAMETERS, irradiance]
    launch(bias_compensation_kernel(features), sps.capacity, inputs, sps.device)

"""Virtual point lights (VPLs) where light paths from the emitters hit surfaces: A. Keller, Instant Radiosity, 1997.

Step 1 of the 2022 paper.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, allocate
from gpu.device_scene.bsdf import BSDF_PARAMETERS, is_grained, is_translucent, largest, sample_lobe
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import (
    LEAST_REFLECTED,
    SIDE_PAIR,
    even_matt,
    even_reflectance,
    matt_side,
    spread_reflectance,
)
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.glass import attenuated
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.scattering import focus_of
from gpu.device_scene.sides import ray_coverage
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.lights.emission import MATT, Particle, emit
from gpu.lights.light_chain import Flight, sent_on, unscattered
from gpu.lights.light_table import LightTable
from gpu.lights.portals import Portals, way_through
from gpu.sampling.sobol import Pair, sobol_pair
from gpu.sampling.warps import cosine_direction


@wp.struct
class Vpls:
    """Virtual point lights, neighbours on a surface side by side.

    position, normal (vpl,) in unit space; to_light (vpl,): unit direction that its light comes from, where light paths
    have left it; flux (vpl,) [W], reflected; bounce (vpl,): how many surfaces its path met before; light (vpl,): what
    its path began at, as gpu.scene.lighting.path_light numbers the parts of a scene.
    A VPL is Lambertian, but for gpu.vpl.vpl_lobes: its intensity in a direction at angle θ from its normal is
    flux · cosθ / π.
    """

    count: int
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    to_light: wp.array[wp.vec3]
    flux: wp.array[wp.vec3]
    bounce: wp.array[int]
    light: wp.array[int]


def allocate_vpls(count: int, device: wp.Device) -> Vpls:
    """`count` VPLs without flux."""
    vpls: Vpls = allocate(Vpls, count, device)
    vpls.count = count
    return vpls


@wp.struct
class WayOn:
    """Where light goes on from a surface, with the `share` of it that counts over `chance`; with chance 0 it ends.

    matt: whether its direction is drawn by the cosine.
    """

    direction: wp.vec3
    share: wp.vec3
    chance: float
    matt: bool


@wp.func
def way_on(surface: Surface, to_light: wp.vec3, even: wp.vec3, pick: float, x: float, y: float) -> WayOn:
    """That of light from unit `to_light`: by the specular lobe of a surface, or evenly, as it reflects `even` of even
    light, by the side that it faces; pick, x, y: uniform in [0, 1).
    """
    way = WayOn()
    surface.normal = surface.geometric_normal
    if surface.f90 > 0.0 and not is_grained(surface):
        matt = even_matt(surface, to_light)
        most = largest(matt)
        lobe = wp.max(largest(even - matt), 0.0)
        by_lobe = wp.max(wp.max(1.0 - most, lobe / (lobe + most)), wp.static(BSDF_PARAMETERS.least_share))
        if pick < by_lobe:
            # Of a lobe's samples those that count less go on less often, so that all carry about as much.
            sample = sample_lobe(surface, to_light, x, y)
            way.direction = sample.direction
            way.share = sample.weight
            way.chance = wp.where(pick < largest(sample.weight), wp.min(largest(sample.weight), by_lobe), 0.0)
            return way
        way.share = matt
        way.chance = 1.0 - by_lobe
    else:
        way.share = even
        way.chance = wp.where(pick < largest(even), largest(even), 0.0)
    way.direction = cosine_direction(surface.normal, x, y)
    way.matt = True
    return way


@wp.func
def sent_by_face(surface: Surface, to_light: wp.vec3, flux: wp.vec3, choice: float, facet: Pair) -> Flight:
    """How light of `flux` from unit `to_light` goes on from a face of frosted glass, without flux if it does not: as
    from a sheet, since light crosses clear faces of a body straight, and would be caught between them and bent ones.

    choice: of the face's side, facet: of its microfacet; all uniform in [0, 1).
    """
    surface.glass = 1.0
    surface.thin = True
    surface.eta = wp.max(surface.eta, 1.0 / surface.eta)
    flight = sent_on(surface, to_light, flux, wp.vec3(0.0, 0.0, 0.0), choice, facet.x, facet.y)
    if wp.dot(flight.direction, surface.geometric_normal) < 0.0:
        flight.absorption = surface.absorption
    return flight


@wp.func
def put_vpl(out: Vpls, place: int, position: wp.vec3, normal: wp.vec3, bounce: int, light: int) -> None:
    """Have a VPL at a place of `out`, but for its flux and where its light comes from."""
    out.position[place] = position
    out.normal[place] = normal
    out.bounce[place] = bounce
    out.light[place] = light


@made_for(*LOOK, "environment", "specular", "frosted", "focus")
def light_path_kernel(features: SceneFeatures, arriving: bool) -> wp.Kernel:
    """The kernel for scenes of these `features`; arriving: flux is what arrives, as photons have it, but for what
    caustics send on, else what is reflected.
    """
    specialise, specular, frosted, lobes = (
        specialisation(features), features.specular, features.frosted, features.focus
    )  # fmt: skip

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def light_path_kernel(
        first: int,
        scene: SceneData,
        table: LightTable,
        counts: wp.array[int],
        bounces: int,
        seeds: wp.array[int],
        portals: Portals,
        out: Vpls,
    ) -> None:
        """One thread a light path: a VPL at each of its `bounces` first hits, at path · bounces + hit; flux 0 if none.
        counts (1,): how many paths there are; those from there on leave nothing. seeds: one element.

        Russian roulette on the albedo's largest channel keeps the flux of surviving particles about equal. Light goes
        on from mirrors and clear glass that emitters light; what other surfaces send finds these matt, or not there.
        Of frosted glass, a face reflects or lets through; what it does is sent to that side as from a matt surface.
        What lobes send on as caustics, no VPL sends. Of what is translucent, one side sends; photons have what would
        send as much from both sides.
        """
        path = first + wp.tid()
        scene = specialise(scene)
        for bounce in range(bounces):
            out.flux[path * bounces + bounce] = wp.vec3(0.0, 0.0, 0.0)
        paths = counts[0]
        if path >= paths:
            return
        seed = seeds[0]
        particle = emit(scene, table, sobol_pair(path, 0, seed).a, sobol_pair(path, 1, seed), sobol_pair(path, 2, seed))
        begins = way_through(portals, particle, table.radius[0], path, 0, seed)
        flight = Flight()
        flight.origin = offset_origin(begins.origin, particle.normal, begins.direction)
        flight.direction = begins.direction
        flight.flux = particle.flux * begins.weight / float(paths)
        begin = int(0)
        if wp.static(specular):
            chain = unscattered(scene, flight, path, 4, bounces, seed)
            if largest(chain.flight.flux) <= 0.0:
                return
            flight = chain.flight
            flight.absorption = wp.vec3(0.0, 0.0, 0.0)
            begin = chain.bounce
        # As of gpu.device_scene.even_light.spread_reflectance.
        focused = float(1.0)
        for bounce in range(begin, bounces):
            scene.coverage = ray_coverage(path, bounce, seed)  # by which `unscattered` came here
            hit = closest_hit(scene, flight.origin, flight.direction, RAY_LENGTH)
            if hit.face == NO_HIT:
                return
            surface = met_at(scene, hit, flight.direction)
            if scene.part_glass and bounce > begin:
                tint = crossed_tint(scene, flight.origin, flight.direction, hit.t, False)
                flight.flux = wp.cw_mul(flight.flux, tint)
            to_light = -flight.direction
            slot = path * bounces + bounce
            place = sobol_pair(path, 3 + 2 * bounce, seed)
            choice = sobol_pair(path, 4 + 2 * bounce, seed)
            if wp.static(frosted):
                flight.flux = wp.cw_mul(flight.flux, attenuated(flight.absorption, hit.t))
                flight.absorption = wp.vec3(0.0, 0.0, 0.0)
                if not surface.clear and choice.y < surface.glass:
                    flight = sent_by_face(surface, to_light, flight.flux, choice.y / surface.glass, place)
                    if largest(flight.flux) <= 0.0:
                        return
                    crosses = wp.dot(flight.direction, surface.geometric_normal) < 0.0
                    side = wp.where(crosses, -surface.geometric_normal, surface.geometric_normal)
                    put_vpl(out, slot, surface.position, side, bounce, particle.light)
                    focused *= focus_of(surface)
                    out.flux[slot] = flight.flux * (1.0 - focused)
                    continue
            whole = even_reflectance(surface, to_light)
            reflectance = whole
            arrives = flight.flux
            if scene.part_glass and surface.crossed and bounce == begin:
                surface.glass = 0.0  # as `unscattered` has chosen
                reflectance = even_reflectance(surface, to_light)
                arrives = wp.cw_div(wp.cw_mul(flight.flux, reflectance), wp.max(whole, LEAST_REFLECTED))
            if is_translucent(surface):
                surface = matt_side(surface, to_light, focused, sobol_pair(path, SIDE_PAIR + bounce, seed).x)
                reflectance = surface.diffuse
                arrives = wp.cw_div(wp.cw_mul(flight.flux, reflectance), wp.max(whole, LEAST_REFLECTED))
            put_vpl(out, slot, surface.position, surface.geometric_normal, bounce, particle.light)
            out.to_light[slot] = to_light
            if wp.static(arriving):
                out.flux[slot] = arrives
            if wp.static(lobes):
                sent = wp.cw_mul(flight.flux, spread_reflectance(surface, to_light, focused))
                if wp.static(arriving):
                    sent = wp.cw_div(sent, wp.max(whole, LEAST_REFLECTED))
                out.flux[slot] = sent
                focused = 0.0
            if wp.static(not arriving and not lobes):
                out.flux[slot] = wp.cw_mul(flight.flux, reflectance)
            if scene.part_glass and surface.crossed:
                if choice.y < surface.glass:
                    normal = surface.geometric_normal
                    flight.direction = normal * (2.0 * wp.dot(normal, to_light)) - to_light
                    flight.origin = offset_origin(surface.position, normal, flight.direction)
                    continue
                surface.glass = 0.0
                reflectance = even_reflectance(surface, to_light)
            way = way_on(surface, to_light, reflectance, choice.x, place.x, place.y)
            if way.chance <= 0.0:
                return
            flight.flux = wp.cw_mul(flight.flux, way.share) / way.chance
            flight.direction = way.direction
            if way.matt:
                usual = Particle()
                usual.origin = surface.position
                usual.normal = surface.geometric_normal
                usual.direction = way.direction
                usual.spread = MATT
                through = way_through(portals, usual, table.radius[0], path, bounce + 1, seed)
                flight.direction = through.direction
                flight.flux = flight.flux * through.weight
                if through.weight <= 0.0:
                    return
            flight.origin = offset_origin(surface.position, surface.geometric_normal, flight.direction)

    return light_path_kernel

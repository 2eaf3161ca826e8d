"""Light paths of caustics: from an emitter by mirrors, clear glass and narrow lobes to a surface that has none of them.

They begin where they are needed, so that neither many lamps nor small glass starve them: at a point of such a surface
that looks for light there, as a shading point does for direct light. Of some such points with their emitters one
is resampled by what it would bring unshadowed (Talbot et al., Importance Resampling for Global Illumination, 2005), so
that all photons bring about as much.

A lobe sends by caustics what `focus_of` it tells, less the rougher it is. VPLs send the rest, as from a matt surface.
"""

from collections.abc import Sequence

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.dispersion import ALL_COLOURS, disperses, drawn_channel, of_channel, refracting
from gpu.device_scene.even_light import even_matt, even_reflectance, spread_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.panes import met_of, transmittance
from gpu.device_scene.part_glass import crossing_share, is_part_glass
from gpu.device_scene.scattering import PartChoice, choose_part, focus_of, is_perfect, part_of
from gpu.device_scene.sides import is_solid, ray_coverage, triangle_normal
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface, surface_at
from gpu.lights.caustic_casters import CausticCasters
from gpu.lights.light_chain import arrived, sent_on
from gpu.lights.light_paths import Vpls
from gpu.lights.light_sampling import LightSample, sample_light
from gpu.lights.light_table import LightTable, choose_emitter
from gpu.sampling.resampling import candidate_at
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import triangle_barycentrics

# Points of which one begins a path, each with an emitter: the length of vectors.
CANDIDATES = wp.constant(16)
Weights = wp.types.vector(length=int(CANDIDATES), dtype=float)
# Of the weight of points that light would reach from behind: most are of closed bodies, where it does not.
BEHIND = wp.constant(0.1)
# Of `sobol_pair`: those below are of candidates, and this one chooses; vertices have those that follow.
CHOICE_PAIR = wp.constant(4)


@wp.struct
class CausticStart:
    """Where a path may begin: a surface, the light that is looked for there, and the flux that it would bring there
    unshadowed and without what crosses sheets straight [W]; weight: by which it is resampled.
    """

    surface: Surface
    light: LightSample
    flux: wp.vec3
    weight: float


@wp.func
def sent_share(part: Surface, to_light: wp.vec3) -> float:
    """About the share of the light from unit `to_light` that the chosen part of a surface sends on by caustics."""
    if is_perfect(part):
        return 1.0
    if part.glass > 0.0:
        return focus_of(part)
    return wp.max(largest(even_reflectance(part, to_light) - even_matt(part, to_light)), 0.0) * focus_of(part)


@wp.func
def caster_share(surface: Surface, to_light: wp.vec3, lobes: bool) -> float:
    """About the share of the light from unit `to_light` that a surface's lobes send on, or else what it has of a mirror
    and of clear glass.
    """
    share = float(0.0)
    for side in range(2):
        chosen = PartChoice()
        chosen.glass = 1.0 - float(side)
        part = part_of(surface, chosen)
        if is_perfect(part) != lobes:
            share += wp.where(side == 0, surface.glass, 1.0 - surface.glass) * sent_share(part, to_light)
    return share


@wp.func
def caustic_start(scene: SceneData, table: LightTable, casters: CausticCasters, index: int, seed: int) -> CausticStart:
    """Candidate number `index` of `seed`."""
    start = CausticStart()
    caster = choose_emitter(casters.choice, sobol_pair(index, 0, seed).a)
    hit = Hit()
    hit.face = casters.faces[caster.index]
    place = sobol_pair(index, 1, seed)
    uv = triangle_barycentrics(place.x, place.y)
    hit.u = uv[0]
    hit.v = uv[1]
    if not is_solid(scene, hit.face, hit.u, hit.v):
        return start
    corner = scene.triangles[hit.face]
    position = (
        scene.vertices[corner[0]] * hit.u
        + scene.vertices[corner[1]] * hit.v
        + scene.vertices[corner[2]] * (1.0 - hit.u - hit.v)
    )
    pick = sobol_pair(index, 2, seed)
    start.light = sample_light(scene, table, table.all_emitters, position, pick.a, sobol_pair(index, 3, seed))
    if largest(start.light.irradiance) <= 0.0:
        return start
    to_light = start.light.direction
    share = float(1.0)
    surface = surface_at(scene, hit, -to_light)
    if scene.part_glass and is_part_glass(scene, hit.face):
        share -= crossing_share(surface, -to_light)
    scene.coverage = wp.uint32(1)  # sheets are crossed by chance, in which light is none of a caustic
    start.surface = met_of(scene, hit.face, -to_light, surface)
    start.surface.coat = 0.0
    cosine = wp.dot(start.surface.geometric_normal, to_light)
    start.flux = start.light.irradiance * (share * cosine * casters.areas[caster.index] / caster.probability)
    start.weight = brightness(start.flux) * caster_share(start.surface, to_light, casters.lobes)
    if wp.dot(triangle_normal(scene, hit.face), to_light) < 0.0 and not start.surface.thin:
        start.weight *= BEHIND
    return start


@wp.func
def chosen_start(scene: SceneData, table: LightTable, casters: CausticCasters, path: int, seed: int) -> CausticStart:
    """Where a path begins, with the flux that it stands for [W]; with the weight 0 if none of the candidates is lit."""
    weights = Weights()
    total = float(0.0)
    start = CausticStart()
    # The last turn looks at the chosen one again: in one place for all, else the kernel takes long to compile.
    for turn in range(CANDIDATES + 1):
        candidate = turn
        if turn == CANDIDATES:
            if total <= 0.0:
                return CausticStart()
            candidate = candidate_at(weights, sobol_pair(path, CHOICE_PAIR, seed).x * total)
        start = caustic_start(scene, table, casters, path * CANDIDATES + candidate, seed)
        if turn < CANDIDATES:
            weights[turn] = start.weight
            total += start.weight
    start.flux = start.flux * (total / (start.weight * float(CANDIDATES)))
    return start


@made_for(*LOOK, "environment", "glass", "panes", "focus", "dispersion")
def caustic_path_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise, lobes = specialisation(features), features.focus

    # As for direct light, whose candidates are looked at likewise.
    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def caustic_path_kernel(first: int, scene: SceneData, table: LightTable, casters: CausticCasters, bounces: int,
                            begin: int, paths: int, seeds: wp.array[int], out: Vpls) -> None:  # fmt: skip
        """One thread a path of the `paths` from these casters, whose places are from `begin` on: a photon where it
        ends, with the flux that arrives; flux 0 if there is none.

        A path meets `bounces` casters at most, and ends after gloss. Where a lobe sends a part on and the rest is
        shown, one of both is drawn by how bright they are. seeds: one element.
        """
        path = first + wp.tid()
        place = begin + path
        scene = specialise(scene)
        out.flux[place] = wp.vec3(0.0, 0.0, 0.0)
        seed = seeds[0]
        start = chosen_start(scene, table, casters, path, seed)
        if start.weight <= 0.0:
            return
        surface = start.surface
        to_light = start.light.direction
        scene.coverage = ray_coverage(path, 0, seed)
        left = transmittance(scene, surface.position, surface.geometric_normal, start.light.point, start.light.normal)
        flux = wp.cw_mul(start.flux, left) / float(paths)
        absorption = wp.vec3(0.0, 0.0, 0.0)
        channel = int(ALL_COLOURS)
        scattered = bool(False)
        ends = bool(False)
        for vertex in range(bounces + 1):
            if largest(flux) <= 0.0:
                return
            pick = sobol_pair(path, CHOICE_PAIR + 1 + vertex, seed)
            chosen = choose_part(surface, to_light, pick.x)
            part = part_of(surface, chosen)
            if scene.dispersive and disperses(part):
                if channel == ALL_COLOURS:
                    channel = drawn_channel(sobol_pair(path, CHOICE_PAIR, seed).y)
                    flux = of_channel(flux, channel)
                part = refracting(part, channel)
            onward = wp.where(is_perfect(part), 1.0, 0.0)
            if wp.static(lobes):
                if vertex == 0:
                    onward = wp.where(is_perfect(part) != casters.lobes, 1.0, 0.0)
                elif ends:
                    onward = 0.0
                elif not is_perfect(part):
                    onward = sent_share(part, to_light)
                    if onward > 0.0 and part.glass == 0.0:
                        onward = onward / (onward + largest(spread_reflectance(part, to_light, 1.0)))
            if pick.y >= onward:
                if vertex > 0:
                    out.position[place] = surface.position
                    out.normal[place] = surface.geometric_normal
                    out.flux[place] = flux / (1.0 - onward)
                return
            flux = flux / onward
            facet = sobol_pair(path, CHOICE_PAIR + 2 + bounces + vertex, seed)
            if wp.static(lobes):
                # To light paths, all but frosted glass is matt from here on.
                ends = part.glass == 0.0 and (scattered or not is_perfect(part))
                scattered = scattered or not is_perfect(part)
                if not is_perfect(part):
                    part.diffuse = wp.vec3(0.0, 0.0, 0.0)
                    part.through = wp.vec3(0.0, 0.0, 0.0)
                    flux = flux * focus_of(part)
            flight = sent_on(part, to_light, flux, absorption, chosen.rest, facet.x, facet.y)
            absorption = flight.absorption
            arrival = arrived(scene, flight, ray_coverage(path, vertex + 1, seed))
            if arrival.face == NO_HIT:
                return
            surface = arrival.surface
            flux = arrival.flux
            to_light = -flight.direction

    return caustic_path_kernel


def trace_caustic_paths(scene: SceneData, table: LightTable, casters: Sequence[CausticCasters], bounces: int,
                        seed: wp.array, features: SceneFeatures, out: Vpls) -> None:  # fmt: skip
    """Trace paths to the places of `out`, over at most `bounces` casters, by `seed` (1,); each kind has its share."""
    kernel = caustic_path_kernel(features)
    out.flux.zero_()
    begin = 0
    for kind in casters:
        paths = int(kind.share * len(out.flux))
        launch(kernel, paths, [scene, table, kind, bounces, begin, paths, seed, out], out.flux.device)
        begin += paths

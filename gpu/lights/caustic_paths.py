"""Light paths of caustics: from an emitter by mirrors and through clear glass to the first surface that is neither.

They begin where they are needed, so that neither many lamps nor small glass starve them: at a point of a mirror or of
glass that looks for light there, as a shading point does for direct light. Of some such points with their emitters one
is resampled by what it would bring unshadowed (Talbot et al., Importance Resampling for Global Illumination, 2005), so
that all photons bring about as much.
"""

from functools import cache

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.panes import crossing_share, is_pane, met_surface, transmittance
from gpu.device_scene.scattering import choose_part, is_perfect, part_of
from gpu.device_scene.sides import is_solid, ray_coverage, triangle_normal
from gpu.device_scene.surface import Surface, surface_at
from gpu.lights.caustic_casters import CausticCasters
from gpu.lights.light_chain import arrived, sent_on
from gpu.lights.light_paths import Vpls
from gpu.lights.light_sampling import LightSample, sample_light
from gpu.lights.light_table import LightTable, choose_emitter
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
def perfect_share(surface: Surface) -> float:
    """The share of a surface that is a mirror or clear glass."""
    share = float(0.0)
    if surface.clear:
        share = surface.glass
    if surface.mirror:
        share += 1.0 - surface.glass
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
    if is_pane(scene, hit.face):
        share -= crossing_share(surface_at(scene, hit, -to_light), -to_light)
    scene.coverage = wp.uint32(1)  # sheets are crossed by chance, in which light is none of a caustic
    start.surface = met_surface(scene, hit, -to_light)
    start.surface.coat = 0.0
    cosine = wp.dot(start.surface.geometric_normal, to_light)
    start.flux = start.light.irradiance * (share * cosine * casters.areas[caster.index] / caster.probability)
    start.weight = brightness(start.flux) * perfect_share(start.surface)
    if wp.dot(triangle_normal(scene, hit.face), to_light) < 0.0 and not start.surface.thin:
        start.weight *= BEHIND
    return start


@wp.func
def chosen_start(scene: SceneData, table: LightTable, casters: CausticCasters, path: int, seed: int) -> CausticStart:
    """Where a path begins, with the flux that it stands for [W]; with the weight 0 if none of the candidates is lit."""
    weights = Weights()
    total = float(0.0)
    for candidate in range(CANDIDATES):
        weights[candidate] = caustic_start(scene, table, casters, path * CANDIDATES + candidate, seed).weight
        total += weights[candidate]
    if total <= 0.0:
        return CausticStart()
    rest = sobol_pair(path, CHOICE_PAIR, seed).x * total
    chosen = int(0)
    for candidate in range(CANDIDATES):
        # Rounding may leave a rest at the end: the last candidate with any weight takes it.
        if rest >= 0.0 and weights[candidate] > 0.0:
            chosen = candidate
            rest -= weights[candidate]
    start = caustic_start(scene, table, casters, path * CANDIDATES + chosen, seed)
    start.flux = start.flux * (total / (start.weight * float(CANDIDATES)))
    return start


@cache
def caustic_path_kernel(texels: bool, environment: bool) -> wp.Kernel:
    """The kernel for scenes whose surfaces show `texels`, or neither textures nor masks, with an environment or not."""

    # As for direct light, whose candidates are looked at likewise.
    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def caustic_path_kernel(first: int, scene: SceneData, table: LightTable, casters: CausticCasters, bounces: int,
                            seeds: wp.array[int], out: Vpls) -> None:  # fmt: skip
        """One thread a path: a photon where it ends, with the flux that arrives; flux 0 if there is none.

        A path meets `bounces` mirrors and glass at most. seeds: one element.
        """
        path = first + wp.tid()
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        if wp.static(not environment):
            scene.has_environment = False
        out.flux[path] = wp.vec3(0.0, 0.0, 0.0)
        seed = seeds[0]
        start = chosen_start(scene, table, casters, path, seed)
        if start.weight <= 0.0:
            return
        surface = start.surface
        to_light = start.light.direction
        scene.coverage = ray_coverage(path, 0, seed)
        left = transmittance(scene, surface.position, surface.geometric_normal, start.light.point, start.light.normal)
        flux = wp.cw_mul(start.flux, left) / float(out.flux.shape[0])
        absorption = wp.vec3(0.0, 0.0, 0.0)
        for vertex in range(bounces + 1):
            if largest(flux) <= 0.0:
                return
            chosen = choose_part(surface, to_light, sobol_pair(path, CHOICE_PAIR + 1 + vertex, seed).x)
            part = part_of(surface, chosen)
            if not is_perfect(part):
                if vertex > 0:
                    out.position[path] = surface.position
                    out.normal[path] = surface.geometric_normal
                    out.flux[path] = flux
                return
            flight = sent_on(part, to_light, flux, absorption, chosen.rest, 0.5, 0.5)
            absorption = flight.absorption
            arrival = arrived(scene, flight, ray_coverage(path, vertex + 1, seed))
            if arrival.face == NO_HIT:
                return
            surface = arrival.surface
            flux = arrival.flux
            to_light = -flight.direction

    return caustic_path_kernel


def trace_caustic_paths(scene: SceneData, table: LightTable, casters: CausticCasters, bounces: int, seed: wp.array,
                        features: SceneFeatures, out: Vpls) -> None:  # fmt: skip
    """Trace a path to each place of `out`, over at most `bounces` mirrors and glass, by `seed` (1,)."""
    kernel = caustic_path_kernel(features.texels, features.environment)
    inputs = [scene, table, casters, bounces, seed, out]
    launch(kernel, len(out.flux), inputs, out.flux.device)

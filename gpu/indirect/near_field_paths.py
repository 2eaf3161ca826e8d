"""Near-field rays that end where no VPL tells the radiosity: they go on as paths, to emitters and to where it is known.

That is in cracks, beside walls and on narrow surfaces, such as frames and edges of shelves, which send a fifth to a
half of a room's near-field light. How densely VPLs lie there tells little, nor may their places stand for the surface:
they lie where it is lit, most of all beside strips of sun.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.panes import transmittance
from gpu.device_scene.rays import closest_hit, lifted
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.vpl.radiosity_cache import RadiosityCache, is_narrow, vpl_around
from gpu.vpl.radiosity_reach import is_apart_of
from gpu.vpl.vpl_reflectance import reflectance_at

# Of the sample sequences of a frame's seed, those that nothing else takes.
CHANCE_PAIR = wp.constant(65)
FIRST_PAIR = wp.constant(66)
PAIRS_A_VERTEX = wp.constant(3)


@wp.struct
class NearPaths:
    """Paths that near-field rays go on as.

    vertices: of each at the most, with the ray's end; bounces: the most surfaces that light meets before an SP;
    usual_share, and radius_share and clearance of a path's rays: as of gpu.indirect.near_field.NearFieldParameters.
    position, normal (sp,): where the near-field ray ended; share (sp,): of the radiosity there that the SP lacks, 0 for
    no path.
    """

    vertices: int
    bounces: int
    usual_share: float
    radius_share: float
    clearance: float
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    share: wp.array[float]


@made_for(*LOOK, "environment", "glass", "panes")
def near_field_path_kernel(features: SceneFeatures, blocked: wp.Function) -> wp.Kernel:
    """The kernel for scenes of these `features`; blocked: as of is_apart_of."""
    specialise, is_apart = specialisation(features), is_apart_of(blocked)

    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def near_field_path_kernel(
        first: int,
        scene: SceneData,
        table: LightTable,
        lit: RadiosityCache,
        pixels: wp.array[int],
        seeds: wp.array[int],
        paths: NearPaths,
        light: wp.array[wp.vec3],
        found: wp.array[int],
    ) -> None:
        """One thread an SP: if its ray goes on, the irradiance that disks took from where it ended: light (pixel,).

        seeds: one element; found (sp,): 1 where there is light.
        """
        sp = first + wp.tid()
        share = paths.share[sp]
        if share <= 0.0:
            return
        seed = seeds[0]
        chance = wp.min(share / paths.usual_share, 1.0)
        if sobol_pair(sp, CHANCE_PAIR, seed).x >= chance:
            return
        share = share / chance
        scene = specialise(scene)
        position = paths.position[sp]
        normal = paths.normal[sp]
        throughput = wp.vec3(share, share, share)
        total = wp.vec3(0.0, 0.0, 0.0)
        for vertex in range(paths.vertices):
            pair = FIRST_PAIR + PAIRS_A_VERTEX * vertex
            surface = reflectance_at(scene, position, normal)
            if largest(surface.even) <= 0.0:
                break
            pick = sobol_pair(sp, pair, seed)
            place = sobol_pair(sp, pair + 1, seed)
            sample = sample_light(scene, table, table.all_emitters, position, pick.a, place)
            cosine = wp.dot(sample.direction, normal)
            if cosine > 0.0:
                reached = transmittance(scene, position, normal, sample.point, sample.normal)
                emitted = wp.cw_mul(sample.irradiance, reached) * cosine
                total += wp.cw_mul(throughput, wp.cw_mul(surface.spread, emitted))
            place = sobol_pair(sp, pair + 2, seed)
            if vertex + 1 == paths.bounces:
                break
            direction = cosine_direction(normal, place.x, place.y)
            origin = lifted(position, normal)
            hit = closest_hit(scene, origin, direction, RAY_LENGTH)
            if hit.face == NO_HIT:
                break
            throughput = wp.cw_mul(throughput, surface.even)
            position = origin + direction * hit.t
            normal = triangle_normal(scene, hit.face)
            normal = wp.where(wp.dot(normal, direction) < 0.0, normal, -normal)
            other = vpl_around(lit, position, normal, paths.radius_share * hit.t)
            if other >= 0:
                is_last = vertex + 1 == paths.vertices
                apart = is_apart(scene, position, normal, origin, lit.position[other], paths.clearance)
                # At the last vertex, what little is told counts.
                if not apart and (is_last or not is_narrow(lit, other)):
                    total += wp.cw_mul(throughput, lit.radiosity[other])
                    break
        light[pixels[sp]] = total
        found[sp] = 1

    return near_field_path_kernel

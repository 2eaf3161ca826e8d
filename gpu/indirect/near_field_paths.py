"""Near-field rays that end where no VPL tells the radiosity: they go on, to an emitter and to where it is known.

That is in cracks, beside walls and on narrow surfaces, such as frames and edges of shelves, which send a fifth to a
half of a room's near-field light. How densely VPLs lie there tells little, nor may their places stand for the surface:
they lie where it is lit, most of all beside strips of sun.
"""

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import RAY_REGISTERS
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import lifted
from gpu.device_scene.panes import crossed_tint, stops_at_pane, transmittance
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.vpl.radiosity_cache import RadiosityCache, vpl_around
from gpu.vpl.radiosity_reach import is_apart_of
from gpu.vpl.vpl_reflectance import reflectance_at, reflectance_of_side

# Of the sample sequences of a frame's seed, those that nothing else takes.
CHANCE_PAIR, PICK_PAIR, PLACE_PAIR, RAY_PAIR = (wp.constant(pair) for pair in range(65, 69))


@wp.struct
class NearPaths:
    """Paths that near-field rays go on as.

    bounces: the most surfaces that light meets before an SP; with more than one, paths have one too many;
    usual_share, and radius_share and clearance of a path's rays: as of gpu.indirect.near_field.NearFieldParameters.
    position, normal (sp,): where the near-field ray ended; share (sp,): of the radiosity there that the SP lacks, 0 for
    no path.
    """

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

    options = {"max_unroll": 1, "fast_math": True}

    @wp.kernel(module="unique", module_options=options, cuda_max_registers=RAY_REGISTERS)
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

        pixels (sp,): of the SPs; seeds: one element; found (sp,): 1 where there is light.
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
        total = wp.vec3(0.0, 0.0, 0.0)
        surface = reflectance_at(scene, position, normal)
        if scene.translucent and largest(surface.through) > 0.0:
            surface = reflectance_of_side(surface, sobol_pair(sp, CHANCE_PAIR, seed).y)
            normal = wp.where(largest(surface.through) > 0.0, -normal, normal)
        pick = sobol_pair(sp, PICK_PAIR, seed)
        place = sobol_pair(sp, PLACE_PAIR, seed)
        sample = sample_light(scene, table, table.all_emitters, position, pick.a, place)
        cosine = wp.dot(sample.direction, normal)
        if cosine > 0.0:
            reached = transmittance(scene, position, normal, sample.point, sample.normal)
            # Weighed by the balance heuristic against the ray below, or one lamp of many close by would be a firefly.
            counted = cosine * share / (1.0 + cosine / PI * sample.solid_angle)
            total += wp.cw_mul(surface.spread, wp.cw_mul(sample.irradiance, reached)) * counted
        turn = sobol_pair(sp, RAY_PAIR, seed)
        direction = cosine_direction(normal, turn.x, turn.y)
        origin = lifted(position, normal)
        hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        met = light_at_hit(scene, table, table.all_emitters, origin, direction, hit)
        density = wp.dot(direction, normal) / PI
        tint = wp.vec3(1.0, 1.0, 1.0)
        if scene.part_glass:
            tint = crossed_tint(scene, origin, direction, hit.t, False)
        if largest(met.radiance) > 0.0 and density > 0.0 and not stops_at_pane(scene, origin, direction, hit.t):
            emitted = met.radiance
            if scene.part_glass:
                emitted = wp.cw_mul(emitted, tint)
            total += wp.cw_mul(surface.spread, emitted) * (PI * share * density / (density + met.density))
        if paths.bounces > 1 and hit.face != NO_HIT:
            end = origin + direction * hit.t
            side = triangle_normal(scene, hit.face)
            side = wp.where(wp.dot(side, direction) < 0.0, side, -side)
            other = vpl_around(lit, end, side, paths.radius_share * hit.t)
            if other >= 0:
                apart = is_apart(scene, end, side, origin, lit.position[other], paths.clearance)
                if not apart:
                    known = wp.cw_mul(surface.even, lit.radiosity[other]) * share
                    if scene.part_glass:
                        known = wp.cw_mul(known, tint)
                    total += known
        light[pixels[sp]] = total
        found[sp] = 1

    return near_field_path_kernel

"""Part glass: sheets of clear glass, whole or in part, as factors, textures or metal say, or alpha tells the share of.

Light crosses the glass straight, dimmed and tinted; the rest of the sheet, if only what reflects, is met as BLEND is
(gpu.device_scene.sides): rays cross at random, by the share of light that does, and what is left of the glass only
reflects to those that do not.
"""

import warp as wp

from gpu.device_scene.data import HALF, WHOLE, Hit, SceneData
from gpu.device_scene.glass import glass_fresnel
from gpu.device_scene.sides import LEAST_SHARE, has_alpha, is_solid, layer_sample, solid_share
from gpu.device_scene.surface import Surface, surface_at
from gpu.sampling.warps import orthonormal

# Between normal and light that a sheet of glass reflects as it does the mean of what comes evenly from all around.
SHEET_COSINE = wp.constant(0.51)


@wp.struct
class Part:
    """What a ray finds of a surface that may be there in part: the share that it meets, `there`, what of that is no
    mirror, `matt`, and what `passes` of light, tinted.
    """

    there: float
    matt: float
    passes: wp.vec3


@wp.func
def crossing_share(surface: Surface, direction: wp.vec3) -> float:
    """The share of light along unit `direction` that goes straight through a sheet, before its tint; 0 for bodies."""
    if not surface.thin:
        return 0.0
    return surface.glass * (1.0 - glass_fresnel(surface, wp.dot(surface.normal, direction)))


@wp.func
def uncrossed(surface: Surface, direction: wp.vec3) -> Surface:
    """What a sheet is to rays along unit `direction` that do not cross it: of a body, all."""
    crosses = crossing_share(surface, direction)
    surface.glass = (surface.glass - crosses) / wp.max(1.0 - crosses, 1.0e-6)
    surface.crossed = surface.thin
    return surface


@wp.func
def is_part_glass(scene: SceneData, face: int) -> bool:
    """Whether a triangle is of such a sheet."""
    return has_alpha(scene, face) and scene.materials[scene.triangle_material[face]].part_glass


@wp.func
def part_at(scene: SceneData, hit: Hit, direction: wp.vec3) -> Part:
    """What a ray along unit `direction` finds where it hit a triangle."""
    part = Part()
    part.there = solid_share(scene, hit.face, hit.u, hit.v)
    part.matt = part.there
    part.passes = wp.vec3(1.0, 1.0, 1.0) * (1.0 - part.there)
    if scene.part_glass and is_part_glass(scene, hit.face):
        surface = surface_at(scene, hit, direction)
        crosses = crossing_share(surface, direction)
        part.passes += surface.albedo * (part.there * crosses)
        part.matt *= 1.0 - surface.glass
        part.there *= 1.0 - crosses
    return part


@wp.func
def mean_direction(normal: wp.vec3) -> wp.vec3:
    """A unit direction into the surface of `normal` along which glass reflects as much as of even light."""
    return orthonormal(normal) * wp.vec3(wp.sqrt(1.0 - SHEET_COSINE * SHEET_COSINE), 0.0, -SHEET_COSINE)


@wp.func
def stands(scene: SceneData, hit: Hit, share: float) -> bool:
    """Whether a ray meets what is there by a `share`, as `scene.coverage` says."""
    least = layer_sample(scene, hit.face, hit.u, hit.v)
    if scene.coverage == HALF:
        least = 0.5
    elif scene.coverage == WHOLE:
        least = LEAST_SHARE
    return share >= least


@wp.func
def meets(scene: SceneData, hit: Hit, direction: wp.vec3) -> bool:
    """Whether a ray along unit `direction`, which hit a triangle, finds something there."""
    if scene.part_glass and is_part_glass(scene, hit.face):
        part = part_at(scene, hit, direction)
        return stands(scene, hit, part.there)
    return is_solid(scene, hit.face, hit.u, hit.v)


@wp.func
def hides(scene: SceneData, hit: Hit, direction: wp.vec3) -> bool:
    """As `meets`, for rays that tell whether two points see each other: tints dim these, too, but colour nothing."""
    if scene.part_glass and is_part_glass(scene, hit.face):
        passes = part_at(scene, hit, direction).passes
        return stands(scene, hit, 1.0 - (passes[0] + passes[1] + passes[2]) / 3.0)
    return is_solid(scene, hit.face, hit.u, hit.v)


@wp.func
def met_at(scene: SceneData, hit: Hit, direction: wp.vec3) -> Surface:
    """The surface that a ray along unit `direction` which knows no panes has met."""
    surface = surface_at(scene, hit, direction)
    if scene.part_glass and is_part_glass(scene, hit.face):
        surface = uncrossed(surface, direction)
    return surface

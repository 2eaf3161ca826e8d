"""Part glass: sheets that are clear glass in part, as factors, textures or metal say, or that alpha tells the share of.

Light crosses the glass straight, dimmed and tinted as through a pane (gpu.device_scene.panes); the rest of the sheet is
met as BLEND is (gpu.device_scene.sides): rays cross at random, by the share of light that does, and what is left of the
glass only reflects to those that do not.
"""

import warp as wp

from gpu.device_scene.data import HALF, WHOLE, Hit, SceneData
from gpu.device_scene.glass import glass_fresnel
from gpu.device_scene.sides import LEAST_SHARE, has_alpha, is_solid, layer_sample, solid_share
from gpu.device_scene.surface import Surface, surface_at


@wp.struct
class Part:
    """What a ray finds of a surface that may be there in part: the share that it meets, `there`, and what `passes` of
    light, tinted.
    """

    there: float
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
    part.passes = wp.vec3(1.0, 1.0, 1.0) * (1.0 - part.there)
    if scene.part_glass and is_part_glass(scene, hit.face):
        surface = surface_at(scene, hit, direction)
        crosses = crossing_share(surface, direction)
        part.passes += surface.albedo * (part.there * crosses)
        part.there *= 1.0 - crosses
    return part


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

"""Clear glass: faces of bodies, here called panes, and sheets (gpu.device_scene.part_glass).

A sheet stands for its two faces (gpu.device_scene.glass): light crosses it straight, dimmed and tinted. Bodies refract:
shadow rays end there, and what light does is found by following it (gpu.lights.caustic_map). Rays of indirect light
pass bodies, but for those that follow it.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import HALF, NO_HIT, Hit, SceneData
from gpu.device_scene.offsets import OFFSET_ULP
from gpu.device_scene.part_glass import is_part_glass, part_at, uncrossed
from gpu.device_scene.rays import (
    LEAST_LEFT,
    MAX_ALPHA_LAYERS,
    any_hit,
    first_hit,
    first_surface,
    in_front,
    segment_between,
    unmasked,
)
from gpu.device_scene.surface import Surface, surface_at


@wp.struct
class TintedHit:
    """Where a ray ends, after panes that leave `tint` of the light."""

    hit: Hit
    tint: wp.vec3


@wp.func
def stops_at_pane(scene: SceneData, origin: wp.vec3, direction: wp.vec3, length: float) -> bool:
    """Whether a body of clear glass refracts light on the open segment of `length` from `origin` along a direction."""
    return scene.pane_count > 0 and any_hit(scene.panes, origin, direction, length)


@wp.func
def layer_after(scene: SceneData, origin: wp.vec3, direction: wp.vec3, start: float, end: float, culls: bool) -> Hit:
    """The first triangle from `start` to `end` of a ray that is there in part; as of gpu.device_scene.rays.first_hit,
    but that hit.t is from the origin on.
    """
    layer = first_hit(scene.masked, origin + direction * start, direction, end - start, culls)
    layer.t += start
    if layer.face != NO_HIT:
        layer.face += scene.opaque_count + scene.pane_count
    return layer


@wp.func
def left_by_parts(scene: SceneData, origin: wp.vec3, direction: wp.vec3, length: float) -> wp.vec3:
    """As `unmasked`, tinted, in scenes with part glass."""
    left = wp.vec3(1.0, 1.0, 1.0)
    start = float(0.0)
    for _layer in range(MAX_ALPHA_LAYERS):
        layer = layer_after(scene, origin, direction, start, length, False)
        if layer.face == NO_HIT:
            return left
        left = wp.cw_mul(left, part_at(scene, layer, direction).passes)
        if largest(left) < LEAST_LEFT:
            return wp.vec3(0.0, 0.0, 0.0)
        start = layer.t + OFFSET_ULP
    return left


@wp.func
def crossed_tint(scene: SceneData, origin: wp.vec3, direction: wp.vec3, length: float, culls: bool) -> wp.vec3:
    """How part glass tints light on the open segment of `length` from `origin` along unit `direction`, of a ray that
    has met none of it there; if not by chance, it is dimmed by what glass mirrors, too. culls: the ray knows no backs
    that can be culled.
    """
    tint = wp.vec3(1.0, 1.0, 1.0)
    if scene.part_glass and scene.masked_count > 0:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            layer = layer_after(scene, origin, direction, start, length - OFFSET_ULP, culls)
            if layer.face == NO_HIT:
                return tint
            if is_part_glass(scene, layer.face):
                part = part_at(scene, layer, direction)
                stays = wp.where(scene.coverage == HALF, part.matt, part.there)
                tint = wp.cw_mul(tint, part.passes / wp.max(1.0 - stays, 1.0e-6))
            start = layer.t + OFFSET_ULP
    return tint


@wp.func
def transmittance(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> wp.vec3:
    """What reaches one surface point of another's light: 1 or 0 as `connected` says, less behind sheets and BLEND."""
    nothing = wp.vec3(0.0, 0.0, 0.0)
    if not (in_front(p, p_normal, q) and in_front(q, q_normal, p)):
        return nothing
    segment = segment_between(p, p_normal, q, q_normal)
    if segment.length == 0.0:
        return wp.vec3(1.0, 1.0, 1.0)
    if scene.opaque_count > 0 and any_hit(scene.opaque, segment.origin, segment.direction, segment.length):
        return nothing
    if stops_at_pane(scene, segment.origin, segment.direction, segment.length):
        return nothing
    if scene.part_glass and scene.masked_count > 0:
        return left_by_parts(scene, segment.origin, segment.direction, segment.length)
    return wp.vec3(1.0, 1.0, 1.0) * unmasked(scene, segment.origin, segment.direction, segment.length)


@wp.func
def tint_between(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> wp.vec3:
    """What part glass leaves of each colour of light from one surface point to another, over the mean of all colours:
    that of a ray which has found that nothing hides one from the other.
    """
    tint = wp.vec3(1.0, 1.0, 1.0)
    if scene.masked_count == 0:
        return tint
    segment = segment_between(p, p_normal, q, q_normal)
    start = float(0.0)
    for _layer in range(MAX_ALPHA_LAYERS):
        layer = layer_after(scene, segment.origin, segment.direction, start, segment.length, False)
        if layer.face == NO_HIT:
            return tint
        if is_part_glass(scene, layer.face):
            passes = part_at(scene, layer, segment.direction).passes
            tint = wp.cw_mul(tint, passes * (3.0 / wp.max(passes[0] + passes[1] + passes[2], 1.0e-6)))
        start = layer.t + OFFSET_ULP
    return tint


@wp.func
def meet(scene: SceneData, origin: wp.vec3, direction: wp.vec3, cull_backs: bool) -> TintedHit:
    """The first surface along a ray, see `first_surface`, or body of glass."""
    met = TintedHit()
    met.hit = first_surface(scene, origin, direction, RAY_LENGTH, cull_backs)
    if scene.pane_count > 0:
        pane = first_hit(scene.panes, origin, direction, met.hit.t, cull_backs)
        if pane.face != NO_HIT:
            met.hit = pane
            met.hit.face += scene.opaque_count
    met.tint = crossed_tint(scene, origin, direction, met.hit.t, cull_backs)
    return met


@wp.func
def met_of(scene: SceneData, face: int, direction: wp.vec3, surface: Surface) -> Surface:
    """What rays along unit `direction` meet of a `surface` of triangle `face`: of a sheet that is crossed by chance,
    what it is to those that do not cross it.
    """
    if scene.part_glass and is_part_glass(scene, face):
        return uncrossed(surface, direction)
    return surface


@wp.func
def met_surface(scene: SceneData, hit: Hit, direction: wp.vec3) -> Surface:
    """The surface that `meet` found, as `met_of` tells."""
    return met_of(scene, hit.face, direction, surface_at(scene, hit, direction))

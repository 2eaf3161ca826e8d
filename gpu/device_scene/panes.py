"""Clear glass, here called panes, sheets and faces of bodies alike.

A sheet stands for its two faces (gpu.device_scene.glass): light crosses it straight, dimmed and tinted. What reflects
there, paths and the camera's rays meet at random. Bodies refract: shadow rays end there, and what light does is found
by following it (gpu.lights.caustic_map). Rays of indirect light pass all panes.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.offsets import OFFSET_ULP
from gpu.device_scene.part_glass import crossing_share, is_part_glass, part_at, uncrossed
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
from gpu.device_scene.sides import layer_sample
from gpu.device_scene.surface import Surface, surface_at


@wp.struct
class TintedHit:
    """Where a ray ends, after panes that leave `tint` of the light."""

    hit: Hit
    tint: wp.vec3


@wp.func
def is_pane(scene: SceneData, face: int) -> bool:
    """Whether a triangle is one of a pane."""
    return face >= scene.opaque_count and face < scene.opaque_count + scene.pane_count


@wp.func
def transmitted(scene: SceneData, origin: wp.vec3, direction: wp.vec3, length: float) -> wp.vec3:
    """What panes on the open segment of `length` from `origin` along unit `direction` leave of light."""
    share = wp.vec3(1.0, 1.0, 1.0)
    if scene.pane_count > 0:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            pane = first_hit(scene.panes, origin + direction * start, direction, length - start, False)
            if pane.face == NO_HIT:
                return share
            pane.face += scene.opaque_count
            surface = surface_at(scene, pane, direction)
            share = wp.cw_mul(share, surface.albedo * crossing_share(surface, direction))
            start += pane.t + OFFSET_ULP
    return share


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
    has met none of it there; culls: nor knows backs that can be culled.
    """
    tint = wp.vec3(1.0, 1.0, 1.0)
    if scene.part_glass:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            layer = layer_after(scene, origin, direction, start, length - OFFSET_ULP, culls)
            if layer.face == NO_HIT:
                return tint
            if is_part_glass(scene, layer.face):
                part = part_at(scene, layer, direction)
                tint = wp.cw_mul(tint, part.passes / wp.max(1.0 - part.there, 1.0e-6))
            start = layer.t + OFFSET_ULP
    return tint


@wp.func
def transmittance(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> wp.vec3:
    """What reaches one surface point of another's light: 1 or 0 as `connected` says, less behind panes and BLEND."""
    nothing = wp.vec3(0.0, 0.0, 0.0)
    if not (in_front(p, p_normal, q) and in_front(q, q_normal, p)):
        return nothing
    segment = segment_between(p, p_normal, q, q_normal)
    if segment.length == 0.0:
        return wp.vec3(1.0, 1.0, 1.0)
    if scene.opaque_count > 0 and any_hit(scene.opaque, segment.origin, segment.direction, segment.length):
        return nothing
    if scene.part_glass:
        parts = left_by_parts(scene, segment.origin, segment.direction, segment.length)
        return wp.cw_mul(transmitted(scene, segment.origin, segment.direction, segment.length), parts)
    left = unmasked(scene, segment.origin, segment.direction, segment.length)
    if left == 0.0:
        return nothing
    return transmitted(scene, segment.origin, segment.direction, segment.length) * left


@wp.func
def meet_panes(scene: SceneData, origin: wp.vec3, direction: wp.vec3, cull_backs: bool) -> TintedHit:
    """`meet` without the tint of part glass."""
    met = TintedHit()
    met.tint = wp.vec3(1.0, 1.0, 1.0)
    met.hit = first_surface(scene, origin, direction, RAY_LENGTH, cull_backs)
    if scene.pane_count > 0:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            pane = first_hit(scene.panes, origin + direction * start, direction, met.hit.t - start, cull_backs)
            if pane.face == NO_HIT:
                return met
            pane.face += scene.opaque_count
            start += pane.t
            surface = surface_at(scene, pane, direction)
            crosses = crossing_share(surface, direction)
            if scene.through_sheets and surface.thin:
                met.tint = wp.cw_mul(met.tint, surface.albedo * crosses)
            elif scene.through_sheets or layer_sample(scene, pane.face, pane.u, pane.v) > crosses:
                met.hit = pane
                met.hit.t = start
                return met
            else:
                met.tint = wp.cw_mul(met.tint, surface.albedo)
            start += OFFSET_ULP
    return met


@wp.func
def meet(scene: SceneData, origin: wp.vec3, direction: wp.vec3, cull_backs: bool) -> TintedHit:
    """The first surface along a ray, see `first_surface`. Bodies are met, sheets at random by `scene.coverage`; with
    `scene.through_sheets` rays cross panes, dimmed by what these reflect.
    """
    met = meet_panes(scene, origin, direction, cull_backs)
    if scene.part_glass:
        met.tint = wp.cw_mul(met.tint, crossed_tint(scene, origin, direction, met.hit.t, cull_backs))
    return met


@wp.func
def meet_sheet(scene: SceneData, origin: wp.vec3, direction: wp.vec3, cull_backs: bool, met: TintedHit) -> TintedHit:
    """The first sheet that a ray crossed before what it `met`, if there is one; the tint is what that reflects."""
    if scene.pane_count > 0:
        pane = first_hit(scene.panes, origin, direction, met.hit.t, cull_backs)
        if pane.face != NO_HIT:
            pane.face += scene.opaque_count
            surface = surface_at(scene, pane, direction)
            if surface.thin:
                share = surface.glass - crossing_share(surface, direction)
                met.hit = pane
                met.tint = wp.vec3(share, share, share)
    return met


@wp.func
def met_of(scene: SceneData, face: int, direction: wp.vec3, surface: Surface) -> Surface:
    """What rays along unit `direction` meet of a `surface` of triangle `face`: of a sheet that is crossed by chance,
    what it is to those that do not cross it.
    """
    crossed = is_pane(scene, face)
    if scene.part_glass:
        crossed = crossed or is_part_glass(scene, face)
    if crossed:
        return uncrossed(surface, direction)
    return surface


@wp.func
def met_surface(scene: SceneData, hit: Hit, direction: wp.vec3) -> Surface:
    """The surface that `meet` found, as `met_of` tells."""
    return met_of(scene, hit.face, direction, surface_at(scene, hit, direction))

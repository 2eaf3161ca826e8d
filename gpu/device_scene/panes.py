"""Clear glass, here called panes, sheets and faces of bodies alike.

A sheet stands for its two faces (gpu.device_scene.glass): light crosses it straight, dimmed and tinted. What reflects
there, paths and the camera's rays meet at random. Bodies refract: shadow rays end there, and what light does is found
by following it (gpu.lights.caustic_map). Rays of indirect light pass all panes.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.glass import glass_fresnel
from gpu.device_scene.rays import (
    MAX_ALPHA_LAYERS,
    OFFSET_ULP,
    any_hit,
    first_hit,
    first_surface,
    in_front,
    segment_between,
    unmasked,
)
from gpu.device_scene.sides import layer_sample
from gpu.device_scene.surface import Surface, surface_at

# Of a sheet's share of glass, which a texture may make less.
MOSTLY = wp.constant(0.5)


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
def crossing_share(surface: Surface, direction: wp.vec3) -> float:
    """The share of light along unit `direction` that goes straight through a sheet, before its tint; 0 for bodies."""
    if not surface.thin:
        return 0.0
    return surface.glass * (1.0 - glass_fresnel(surface, wp.dot(surface.normal, direction)))


@wp.func
def is_mostly_glass(surface: Surface) -> bool:
    """Whether a sheet is taken for glass, by rays that meet nothing at random; no body is."""
    return surface.thin and surface.glass >= MOSTLY


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
    left = unmasked(scene, segment.origin, segment.direction, segment.length)
    if left == 0.0:
        return nothing
    return transmitted(scene, segment.origin, segment.direction, segment.length) * left


@wp.func
def meet(scene: SceneData, origin: wp.vec3, direction: wp.vec3, cull_backs: bool) -> TintedHit:
    """The first surface along a ray, see `first_surface`. Bodies are met, sheets at random by `scene.coverage`; with
    `scene.through_sheets` rays cross what is mostly glass, dimmed by what that reflects, and meet the others.
    """
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
            if scene.through_sheets and is_mostly_glass(surface):
                met.tint = wp.cw_mul(met.tint, surface.albedo * (crosses / surface.glass))
            elif scene.through_sheets or layer_sample(scene, pane.face, pane.u, pane.v) > crosses:
                met.hit = pane
                met.hit.t = start
                return met
            else:
                met.tint = wp.cw_mul(met.tint, surface.albedo)
            start += OFFSET_ULP
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
    """What rays along unit `direction` meet of a `surface` of triangle `face`: of a pane that is crossed by chance,
    what it is to those that do not cross it.
    """
    if is_pane(scene, face) and (not scene.through_sheets or is_mostly_glass(surface)):
        crosses = crossing_share(surface, direction)
        surface.glass = (surface.glass - crosses) / wp.max(1.0 - crosses, 1.0e-6)
        surface.crossed = surface.thin
    return surface


@wp.func
def met_surface(scene: SceneData, hit: Hit, direction: wp.vec3) -> Surface:
    """The surface that `meet` found, as `met_of` tells."""
    return met_of(scene, hit.face, direction, surface_at(scene, hit, direction))

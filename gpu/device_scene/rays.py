"""Rays against the scene: the only place that knows of the BVHs."""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.device_scene.bvh import Bvh, intersect
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.offsets import OFFSET_ULP, POINT_GAP, lifted
from gpu.device_scene.part_glass import hides, meets
from gpu.device_scene.sides import solid_share

# A ray that meets more masks than this ends: a loop has to.
MAX_ALPHA_LAYERS = wp.constant(64)
# Light that BLEND surfaces leave less of is none.
LEAST_LEFT = wp.constant(1.0 / 1024.0)


@wp.func
def first_hit(bvh: Bvh, origin: wp.vec3, direction: wp.vec3, max_t: float, cull_backs: bool) -> Hit:
    """The first triangle of a tree along a ray; cull_backs: that is not met from behind where that can be culled."""
    nearest = intersect(bvh, origin, direction, max_t, False, cull_backs)
    hit = Hit()
    hit.t = nearest[0]
    hit.u = nearest[1]
    hit.v = nearest[2]
    hit.face = wp.cast(nearest[3], int)
    return hit


@wp.func
def any_hit(bvh: Bvh, origin: wp.vec3, direction: wp.vec3, max_t: float) -> bool:
    """Whether a ray meets any triangle of a tree."""
    return wp.cast(intersect(bvh, origin, direction, max_t, True, False)[3], int) != NO_HIT


@wp.func
def first_surface(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float, cull_backs: bool) -> Hit:
    """The first surface along a ray, whose back is not met where `cull_backs` and it can be culled."""
    hit = Hit()
    hit.face = NO_HIT
    hit.t = max_t
    if scene.opaque_count > 0:
        hit = first_hit(scene.opaque, origin, direction, max_t, cull_backs)
    return nearer_in_part(scene, origin, direction, hit, cull_backs)


@wp.func
def nearer_in_part(scene: SceneData, origin: wp.vec3, direction: wp.vec3, hit: Hit, cull_backs: bool) -> Hit:
    """A `hit`, or what a ray meets before hit.t of what is there in part."""
    if scene.masked_count > 0:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            layer = first_hit(scene.masked, origin + direction * start, direction, hit.t - start, cull_backs)
            if layer.face == NO_HIT:
                break
            layer.face += scene.opaque_count + scene.pane_count
            start += layer.t
            if meets(scene, layer, direction):
                hit = layer
                hit.t = start
                break
            start += OFFSET_ULP
    return hit


@wp.func
def closest_hit(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float) -> Hit:
    """The first surface that light meets along a ray; hit.face is NO_HIT where there is none. `direction` has unit
    length.
    """
    return first_surface(scene, origin, direction, max_t, False)


@wp.func
def seen_hit(scene: SceneData, origin: wp.vec3, direction: wp.vec3) -> Hit:
    """The first surface that a camera sees along a ray; hit.face is NO_HIT where there is none."""
    return first_surface(scene, origin, direction, RAY_LENGTH, scene.one_sided)


@wp.func
def backdrop_hit(scene: SceneData, origin: wp.vec3, direction: wp.vec3) -> Hit:
    """The sky around the scene where a ray that meets nothing else sees it; hit.face is NO_HIT where it does not."""
    hit = Hit()
    hit.face = NO_HIT
    if scene.backdrop_count > 0:
        hit = first_hit(scene.backdrop, origin, direction, RAY_LENGTH, scene.one_sided)
        if hit.face != NO_HIT:
            hit.face += scene.opaque_count + scene.pane_count + scene.masked_count
    return hit


@wp.func
def occluded(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float) -> bool:
    """Whether anything stands on the open segment of length `max_t` from `origin` along unit `direction`."""
    if scene.opaque_count > 0 and any_hit(scene.opaque, origin, direction, max_t):
        return True
    if scene.masked_count > 0:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            layer = first_hit(scene.masked, origin + direction * start, direction, max_t - start, False)
            if layer.face == NO_HIT:
                return False
            layer.face += scene.opaque_count + scene.pane_count
            if hides(scene, layer, direction):
                return True
            start += layer.t + OFFSET_ULP
    return False


@wp.func
def unmasked(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float) -> float:
    """The share of light that masked and BLEND surfaces leave on the open segment of length `max_t` from `origin`."""
    left = float(1.0)
    if scene.masked_count > 0:
        start = float(0.0)
        for _layer in range(MAX_ALPHA_LAYERS):
            layer = first_hit(scene.masked, origin + direction * start, direction, max_t - start, False)
            if layer.face == NO_HIT:
                return left
            left *= 1.0 - solid_share(scene, scene.opaque_count + scene.pane_count + layer.face, layer.u, layer.v)
            if left < LEAST_LEFT:
                return 0.0
            start += layer.t + OFFSET_ULP
    return left


@wp.func
def occluded_solid(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float) -> bool:
    """As `occluded` for a scene whose masks are ignored: no textures, hence far fewer registers and twice the rays."""
    if scene.opaque_count > 0 and any_hit(scene.opaque, origin, direction, max_t):
        return True
    return scene.masked_count > 0 and any_hit(scene.masked, origin, direction, max_t)


@wp.func
def occluded_opaque(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float) -> bool:
    """As `occluded` for a scene without masks."""
    return scene.opaque_count > 0 and any_hit(scene.opaque, origin, direction, max_t)


@wp.struct
class Segment:
    """What lies between two surface points: from `origin` along unit `direction`; length 0 when nothing can."""

    origin: wp.vec3
    direction: wp.vec3
    length: float


@wp.func
def segment_between(p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> Segment:
    """The open segment from `p` to `q`, both moved off the sides of their surfaces that the geometric normals name.

    Not to the sides that they lie on of each other: in one plane, rounding would put one of them behind its surface.
    `q` may be on none, and have the normal zero.
    """
    segment = Segment()
    segment.origin = lifted(p, p_normal)
    between = lifted(q, q_normal) - segment.origin
    distance = wp.length(between)
    # Points closer than their offsets have nothing between them; a zero direction would be "missed" anyway.
    if distance > POINT_GAP:
        segment.direction = between / distance
        segment.length = distance - wp.where(wp.length_sq(q_normal) > 0.0, 0.0, POINT_GAP)
    return segment


@wp.func
def in_front(p: wp.vec3, p_normal: wp.vec3, q: wp.vec3) -> bool:
    """Whether `q` is not behind the surface at `p`; a normal that is bent or averaged elsewhere may say otherwise."""
    return wp.dot(p_normal, q - p) >= -OFFSET_ULP


@wp.func
def unblocked(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """Whether nothing stands between two surface points, whichever way they face."""
    segment = segment_between(p, p_normal, q, q_normal)
    return segment.length == 0.0 or not occluded(scene, segment.origin, segment.direction, segment.length)


@wp.func
def unblocked_solid(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """As `unblocked` for a scene whose masks are ignored or that has none."""
    segment = segment_between(p, p_normal, q, q_normal)
    return segment.length == 0.0 or not occluded_solid(scene, segment.origin, segment.direction, segment.length)


@wp.func
def unblocked_opaque(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """As `unblocked` for a scene without masks."""
    segment = segment_between(p, p_normal, q, q_normal)
    return segment.length == 0.0 or not occluded_opaque(scene, segment.origin, segment.direction, segment.length)


@wp.func
def connected(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """Whether two surface points, given with the geometric normals of their sides, see each other's sides.

    A point that is on no surface has the normal zero.
    """
    if not (in_front(p, p_normal, q) and in_front(q, q_normal, p)):
        return False
    return unblocked(scene, p, p_normal, q, q_normal)


@wp.func
def connected_solid(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """As `connected` for a scene whose masks are ignored or that has none."""
    if not (in_front(p, p_normal, q) and in_front(q, q_normal, p)):
        return False
    return unblocked_solid(scene, p, p_normal, q, q_normal)


@wp.func
def connected_opaque(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """As `connected` for a scene without masks."""
    if not (in_front(p, p_normal, q) and in_front(q, q_normal, p)):
        return False
    return unblocked_opaque(scene, p, p_normal, q, q_normal)


def _cheapest(scene: SceneData, masked: wp.Function, solid: wp.Function, opaque: wp.Function) -> wp.Function:
    """Of functions that look at masks, take them for solid, or leave them out: the last that is right for `scene`."""
    if scene.alpha:
        return masked
    return solid if scene.masked_count > 0 else opaque


def connection(scene: SceneData) -> wp.Function:
    """The cheapest of `connected` and its variants that is right for `scene`."""
    return _cheapest(scene, connected, connected_solid, connected_opaque)


def free_path(scene: SceneData) -> wp.Function:
    """The cheapest of `unblocked` and its variants that is right for `scene`."""
    return _cheapest(scene, unblocked, unblocked_solid, unblocked_opaque)


def blocking(scene: SceneData) -> wp.Function:
    """The cheapest of `occluded` and its variants that is right for `scene`."""
    return _cheapest(scene, occluded, occluded_solid, occluded_opaque)

"""Offsets at the ends of rays, so that none meets the surface that it begins or ends on."""

import warp as wp

# A ray that starts on a triangle hits it at t = 0, so both ends move off their surfaces by this many units in the last
# place of the position (Wächter and Binder, Ray Tracing Gems, ch. 6); unit space bounds the position by 1/2.
OFFSET_ULP = wp.constant(32.0 * 1.1920929e-07)
# Nearer to the origin float32 resolves finer than the intersection test, which rounds at the scale of the box.
OFFSET_FLOOR = wp.constant(0.0625)
# Rays to a point that is on no surface, such as a lamp, end so far before it, and those from a lamp begin so far from
# it: it may lie in a wall's plane.
POINT_GAP = wp.constant(4.0 * OFFSET_ULP)


@wp.func
def offset_at(position: wp.vec3) -> float:
    """How far ends of rays at `position` move, in unit space."""
    size = wp.max(wp.max(wp.abs(position[0]), wp.abs(position[1])), wp.abs(position[2]))
    return OFFSET_ULP * wp.max(size, OFFSET_FLOOR)


@wp.func
def lifted(position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """`position` moved off its surface to the side of its geometric `normal`."""
    return position + normal * offset_at(position)


@wp.func
def drawn_back(position: wp.vec3, normal: wp.vec3, direction: wp.vec3) -> wp.vec3:
    """`position`, hit along `direction`, moved back within its surface of geometric `normal`.

    Where surfaces meet rounding may put a hit on or behind the other one, and light from outside would reach it.
    """
    return position - (direction - normal * wp.dot(normal, direction)) * offset_at(position)


@wp.func
def offset_origin(position: wp.vec3, normal: wp.vec3, direction: wp.vec3) -> wp.vec3:
    """`position` moved off its surface (geometric `normal`) to the side that `direction` points to."""
    return lifted(position, wp.where(wp.dot(normal, direction) < 0.0, -normal, normal))

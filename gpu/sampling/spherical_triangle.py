"""Solid angles of triangles and directions uniform in them: no 1/d² where a light is near."""

import warp as wp


@wp.struct
class Corners:
    """Unit directions to a triangle's corners, counter-clockwise where it is seen from the front."""

    a: wp.vec3
    b: wp.vec3
    c: wp.vec3


@wp.func
def triangle_solid_angle(corners: Corners) -> float:
    """Solid angle of a triangle [sr], negative where it is seen from behind (van Oosterom and Strackee, 1983)."""
    volume = wp.dot(corners.a, wp.cross(corners.b, corners.c))
    rest = 1.0 + wp.dot(corners.a, corners.b) + wp.dot(corners.b, corners.c) + wp.dot(corners.c, corners.a)
    return -2.0 * wp.atan2(volume, rest)


@wp.func
def orthogonal_part(v: wp.vec3, axis: wp.vec3) -> wp.vec3:
    """Unit vector of the part of `v` orthogonal to unit `axis`."""
    return wp.normalize(v - axis * wp.dot(v, axis))


@wp.func
def triangle_direction(corners: Corners, solid_angle: float, x: float, y: float) -> wp.vec3:
    """A uniform direction in a triangle's `solid_angle` (J. Arvo, Stratified Sampling of Spherical Triangles, 1995)."""
    a = corners.a
    b = corners.b
    # The angle at a, and the corner on the arc from a to c that leaves the share x of the solid angle beside b.
    cos_alpha = wp.clamp(wp.dot(orthogonal_part(b, a), orthogonal_part(corners.c, a)), -1.0, 1.0)
    sin_alpha = wp.max(wp.sqrt(1.0 - cos_alpha * cos_alpha), 1.0e-6)
    sin_area = wp.sin(x * solid_angle)
    cos_area = wp.cos(x * solid_angle)
    sin_phi = cos_area * sin_alpha - sin_area * cos_alpha
    cos_phi = -cos_area * cos_alpha - sin_area * sin_alpha
    k1 = cos_phi + cos_alpha
    k2 = sin_phi - sin_alpha * wp.dot(a, b)
    divisor = (k2 * sin_phi + k1 * cos_phi) * sin_alpha
    cosine = float(1.0)
    if divisor != 0.0:
        cosine = wp.clamp((k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / divisor, -1.0, 1.0)
    corner = a * cosine + orthogonal_part(corners.c, a) * wp.sqrt(1.0 - cosine * cosine)
    # A point of the arc from b to that corner, uniform in height over b.
    height = 1.0 - y * (1.0 - wp.dot(corner, b))
    radius = wp.sqrt(wp.max(1.0 - height * height, 0.0))
    return wp.normalize(b * height + orthogonal_part(corner, b) * radius)

"""Mappings of uniform samples to directions, disks and triangles."""

import warp as wp

from gpu.core.constants import TWO_PI


@wp.func
def orthonormal(normal: wp.vec3) -> wp.mat33:
    """Columns tangent, bitangent and unit `normal` (Duff et al., Building an Orthonormal Basis, Revisited, 2017)."""
    s = wp.where(normal[2] < 0.0, -1.0, 1.0)
    a = -1.0 / (s + normal[2])
    b = normal[0] * normal[1] * a
    tangent = wp.vec3(1.0 + s * normal[0] * normal[0] * a, s * b, -s * normal[0])
    bitangent = wp.vec3(b, s + normal[1] * normal[1] * a, -normal[1])
    return wp.matrix_from_cols(tangent, bitangent, normal)


@wp.func
def on_disk(x: float, y: float) -> wp.vec2:
    """A uniform point of the unit disk."""
    radius = wp.sqrt(x)
    return wp.vec2(radius * wp.cos(TWO_PI * y), radius * wp.sin(TWO_PI * y))


@wp.func
def cosine_direction(normal: wp.vec3, x: float, y: float) -> wp.vec3:
    """A direction about unit `normal` with density cosθ/π."""
    disk = on_disk(x, y)
    height = wp.sqrt(wp.max(1.0 - x, 0.0))
    return wp.normalize(orthonormal(normal) * wp.vec3(disk[0], disk[1], height))


@wp.func
def cone_direction(axis: wp.vec3, cos_angle: float, x: float, y: float) -> wp.vec3:
    """A uniform direction of the cone about unit `axis`; density 1 / (2π(1 − cos_angle))."""
    height = 1.0 - x * (1.0 - cos_angle)
    radius = wp.sqrt(wp.max(1.0 - height * height, 0.0))
    return orthonormal(axis) * wp.vec3(radius * wp.cos(TWO_PI * y), radius * wp.sin(TWO_PI * y), height)


@wp.func
def sky_direction(x: float, y: float) -> wp.vec3:
    """A direction towards the sky with density (1 + ω·up)/(4π), which is the sky's own distribution of radiance."""
    height = 2.0 * wp.sqrt(x) - 1.0
    radius = wp.sqrt(wp.max(1.0 - height * height, 0.0))
    return wp.vec3(radius * wp.cos(TWO_PI * y), height, radius * wp.sin(TWO_PI * y))


@wp.func
def triangle_barycentrics(x: float, y: float) -> wp.vec2:
    """Barycentrics (u, v) of a uniform point of a triangle."""
    root = wp.sqrt(x)
    return wp.vec2(1.0 - root, y * root)

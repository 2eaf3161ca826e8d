"""Which points and pixels are of one surface, so that they may share light."""

import warp as wp

from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer

NORMAL_POWER = wp.constant(16.0)


@wp.func
def surface_weight(normal: wp.vec3, geometric_normal: wp.vec3, way: wp.vec3, other: wp.vec3, limit: float) -> float:
    """How much a point that lies `way` from one with these normals is of its surface, 0 to 1, by its normal `other`.

    limit: how far off the plane it may be, about.
    """
    off = wp.dot(geometric_normal, way)
    return wp.pow(wp.max(wp.dot(normal, other), 0.0), NORMAL_POWER) * wp.exp(-(off * off) / (limit * limit + 1.0e-30))


@wp.func
def edge_stopping_weight(gbuffer: GBuffer, p: int, q: int, step: int, tolerance: float) -> float:
    """Share that pixel `q`, `step` pixels away, has in pixel `p` by their surfaces: 0 for different ones.

    tolerance: how many of its spacings a step a pixel may be off the plane of another's surface.
    """
    if gbuffer.face[q] == NO_HIT:
        return 0.0
    way = gbuffer.position[q] - gbuffer.position[p]
    limit = tolerance * gbuffer.spacing[p] * float(step)
    return surface_weight(gbuffer.normal[p], gbuffer.geometric_normal[p], way, gbuffer.normal[q], limit)

"""Which pixels show one surface, so that they may share light."""

import warp as wp

from gpu.gbuffer import GBuffer
from gpu.resident import NO_HIT

# Pixels off the plane of a pixel's surface by this many of its spacings a step are of another surface.
PLANE_TOLERANCE = wp.constant(1.0)
NORMAL_POWER = wp.constant(16.0)


@wp.func
def kinship(gbuffer: GBuffer, p: int, q: int, step: int) -> float:
    """Share that pixel `q`, `step` pixels away, has in pixel `p` by their surfaces: 0 for different ones."""
    if gbuffer.face[q] == NO_HIT:
        return 0.0
    alike = wp.max(wp.dot(gbuffer.normal[p], gbuffer.normal[q]), 0.0)
    off = wp.dot(gbuffer.geometric[p], gbuffer.position[q] - gbuffer.position[p])
    limit = PLANE_TOLERANCE * gbuffer.spacing[p] * float(step)
    return wp.pow(alike, NORMAL_POWER) * wp.exp(-(off * off) / (limit * limit + 1.0e-30))

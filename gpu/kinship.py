"""Which pixels show one surface, so that they may share light."""

import warp as wp

from gpu.gbuffer import GBuffer
from gpu.resident import NO_HIT

NORMAL_POWER = wp.constant(16.0)


@wp.func
def kinship(gbuffer: GBuffer, p: int, q: int, step: int, tolerance: float) -> float:
    """Share that pixel `q`, `step` pixels away, has in pixel `p` by their surfaces: 0 for different ones.

    tolerance: how many of its spacings a step a pixel may be off the plane of another's surface.
    """
    if gbuffer.face[q] == NO_HIT:
        return 0.0
    alike = wp.max(wp.dot(gbuffer.normal[p], gbuffer.normal[q]), 0.0)
    off = wp.dot(gbuffer.geometric[p], gbuffer.position[q] - gbuffer.position[p])
    limit = tolerance * gbuffer.spacing[p] * float(step)
    return wp.pow(alike, NORMAL_POWER) * wp.exp(-(off * off) / (limit * limit + 1.0e-30))

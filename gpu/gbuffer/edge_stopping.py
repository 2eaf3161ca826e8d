"""Edge-stopping weights: how far points and pixels show one surface, so that they may share light.

Such weights are those of SVGF (C. Schied et al., Spatiotemporal Variance-Guided Filtering, 2017), with the
distance from the plane in place of the gradient of depth.
"""

import warp as wp

from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer

# One for all who ask whether points are of one surface, who differ in how far off its plane these may be. Compiled in,
# since filters raise to it at every tap.
NORMAL_POWER = wp.constant(16.0)


# Chains may spread pixels over a surface more than straight rays do, through curved glass.
MAX_STRETCH = wp.constant(4.0)


@wp.func
def is_beside(gbuffer: GBuffer, pixel: int, offset: wp.vec3, step: int) -> bool:
    """Whether a point at `offset` from the SP of `pixel` is as near as points of its surface `step` pixels away are.

    Without chains, points of one plane that pixels beside each other see always are; beside a mirror's edge and in
    curved glass they may be far apart.
    """
    if not gbuffer.chains:
        return True
    # A surface that is seen at a slant has its pixels farther apart.
    facing = wp.abs(wp.dot(gbuffer.geometric_normal[pixel], gbuffer.to_camera[pixel]))
    return wp.length(offset) * facing <= MAX_STRETCH * gbuffer.spacing[pixel] * float(step)


@wp.func
def surface_weight(normal: wp.vec3, geometric_normal: wp.vec3, offset: wp.vec3, other: wp.vec3, limit: float) -> float:
    """How far a point at `offset` from one with these normals belongs to its surface, 0 to 1, by its normal `other`.

    limit: distance from the plane at which the weight has fallen to 1/e.
    """
    distance = wp.dot(geometric_normal, offset)
    alike = wp.pow(wp.max(wp.dot(normal, other), 0.0), NORMAL_POWER)
    return alike * wp.exp(-(distance * distance) / (limit * limit + 1.0e-30))


@wp.func
def edge_stopping_weight(gbuffer: GBuffer, p: int, q: int, step: int, tolerance: float) -> float:
    """How far pixel `q`, `step` pixels away, shows the surface of pixel `p`, 0 to 1.

    tolerance: distance from the plane of `p` at which the weight has fallen to 1/e, in spacings of `p` times `step`.
    """
    if gbuffer.face[q] == NO_HIT:
        return 0.0
    offset = gbuffer.position[q] - gbuffer.position[p]
    if not is_beside(gbuffer, p, offset, step):
        return 0.0
    limit = tolerance * gbuffer.spacing[p] * float(step)
    return surface_weight(gbuffer.normal[p], gbuffer.geometric_normal[p], offset, gbuffer.normal[q], limit)

"""Edge-stopping weights: how far points and pixels show one surface, so that they may share light.

Such weights are those of SVGF (C. Schied et al., Spatiotemporal Variance-Guided Filtering, 2017), with the
distance from the plane in place of the gradient of depth.
"""

from dataclasses import dataclass

import warp as wp

from gpu.device_scene.bsdf import BSDF_PARAMETERS
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer


@dataclass(frozen=True)
class EdgeStoppingParameters:
    """For all who ask whether points are of one surface, who differ in how far off its plane these may be. Compiled in,
    since filters compute with them at every tap.

    normal_power: of the cosine between normals; roughness_tolerance, share_tolerance: what is seen in narrow specular
    lobes is other light where roughness or the lobes' share of what is reflected differs by this; max_stretch: chains
    may spread pixels over a surface so many times more than straight rays do, through curved glass.
    """

    normal_power: float = 16.0
    roughness_tolerance: float = 0.05
    share_tolerance: float = 0.1
    max_stretch: float = 4.0


EDGE_STOPPING_PARAMETERS = EdgeStoppingParameters()


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
    reach = wp.static(EDGE_STOPPING_PARAMETERS.max_stretch) * gbuffer.spacing[pixel] * float(step)
    return wp.length(offset) * facing <= reach


@wp.func
def surface_weight(normal: wp.vec3, geometric_normal: wp.vec3, offset: wp.vec3, other: wp.vec3, limit: float) -> float:
    """How far a point at `offset` from one with these normals belongs to its surface, 0 to 1, by its normal `other`.

    limit: distance from the plane at which the weight has fallen to 1/e.
    """
    distance = wp.dot(geometric_normal, offset)
    alike = wp.pow(wp.max(wp.dot(normal, other), 0.0), wp.static(EDGE_STOPPING_PARAMETERS.normal_power))
    return alike * wp.exp(-(distance * distance) / (limit * limit + 1.0e-30))


@wp.func
def specular_part(gbuffer: GBuffer, pixel: int) -> float:
    """The specular lobe's share of what an SP reflects, head-on."""
    specular = wp.max(gbuffer.f0[pixel])
    return specular / (specular + wp.max(gbuffer.diffuse[pixel]) + 1.0e-6)


@wp.func
def gloss_weight(gbuffer: GBuffer, p: int, q: int) -> float:
    """How far the SPs of pixels `p` and `q` reflect direct light alike, 0 to 1: 1 where neither has a narrow lobe."""
    if not gbuffer.gloss:
        return 1.0
    widest = wp.static(BSDF_PARAMETERS.glossy_roughness)
    narrow = gbuffer.f90[p] > 0.0 and gbuffer.roughness[p] < widest
    if not (narrow or (gbuffer.f90[q] > 0.0 and gbuffer.roughness[q] < widest)):
        return 1.0
    rougher = (gbuffer.roughness[q] - gbuffer.roughness[p]) / wp.static(EDGE_STOPPING_PARAMETERS.roughness_tolerance)
    part = specular_part(gbuffer, q) - specular_part(gbuffer, p)
    part = part / wp.static(EDGE_STOPPING_PARAMETERS.share_tolerance)
    return wp.exp(-rougher * rougher - part * part)


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

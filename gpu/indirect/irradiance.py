"""Indirect light at the shading points, as stages leave it to each other."""

import warp as wp

from gpu.core.device import allocate

# VPL clusters drawn for each SP, to which it sends rays of its own (gpu.correction.visibility_correction).
CHECKS = 4
# Near VPL clusters are walked in so many parts by who draws from them with more threads
# (gpu.correction.adaptive_ray_sampling).
NEAR_PARTS = 8


@wp.struct
class Indirect:
    """Indirect light at the SPs.

    irradiance (pixel,) [W/m²]; lost (pixel,): what rounding added to an `irradiance` that is gathered run by run, as
    gpu.core.kahan.Sum; target (CHECKS, sp): near VPL clusters, each drawn in proportion to its light in
    visibility_weight, −1 for none; near_importance, far_importance (sp,): all light in visibility_weight of near VPL
    clusters, and of the others; unoccluded_near, unoccluded_far (sp,): their light were none hidden;
    unoccluded_prefix (part, sp): that of the near ones before each part of VPL clusters (`words_a_part`); pairs (sp,):
    how many are near.
    """

    irradiance: wp.array[wp.vec3]
    lost: wp.array[wp.vec3]
    target: wp.array2d[int]
    near_importance: wp.array[float]
    far_importance: wp.array[float]
    unoccluded_near: wp.array[float]
    unoccluded_far: wp.array[float]
    unoccluded_prefix: wp.array2d[float]
    pairs: wp.array[int]


def allocate_indirect(pixels: int, device: wp.Device) -> Indirect:
    """Indirect light of `pixels` pixels."""
    indirect: Indirect = allocate(Indirect, pixels, device, CHECKS, pauses=True)
    indirect.unoccluded_prefix = wp.zeros((NEAR_PARTS, pixels), dtype=float, device=device)
    return indirect

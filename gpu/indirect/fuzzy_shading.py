"""Indirect light at every shading point from all VPL clusters. Step 6 and Eq. 6 and 9 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.intrinsics import bits_of_warp, lowest_bit
from gpu.core.kahan import Sum, kahan_add
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.clustered_light import ClusteredLight, guides_of
from gpu.indirect.far_field import far_irradiance, visibility_weight
from gpu.indirect.irradiance import CHECKS, NEAR_PARTS, Indirect
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.form_factor import unoccluded_irradiance
from gpu.vpl.group_sampling import column_total
from gpu.vpl.vpl_clusters import VplClusters

Ints = wp.types.vector(length=CHECKS, dtype=int)
Floats = wp.types.vector(length=CHECKS, dtype=float)
# Fewer than the compiler would take, so that more threads run at once.
REGISTERS = 80
SHADE_KEY = wp.constant(wp.uint32(0x68E31DA4))


@wp.func
def words_a_part(vpls: VplClusters) -> int:
    """How many words of 32 VPL clusters each part has; the last parts may have fewer or none."""
    return (vpls.count + 32 * NEAR_PARTS - 1) // (32 * NEAR_PARTS)


@cache
def fuzzy_shading_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that shades SPs of F = `fuzziness` clusters each."""
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)
    guides = guides_of(fuzziness)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def fuzzy_shading_kernel(
        first: int, gbuffer: GBuffer, points: PointList, known: ClusteredLight, seed: wp.array[int], out: Indirect
    ) -> None:
        """One thread an SP: its light from all VPL clusters, with visibility averaged over its SP clusters."""
        sp = first + wp.tid()
        if sp >= points.count[0]:
            out.pairs[sp] = 0
            return
        vpls = known.vpls
        far = known.far
        pixel = points.pixels[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        state = hashed(wp.uint32(pixel) ^ hashed(SHADE_KEY + wp.uint32(seed[0])))
        guided = guides(known, sp, position, normal)
        cluster = guided.cluster
        weights = guided.weight
        irradiance = Sum()
        far_importance = float(0.0)
        unoccluded_far = float(0.0)
        for f in range(wp.static(fuzziness)):
            if weights[f] > 0.0:
                light = far_irradiance(far, known.clusters, cluster[f], position, normal)
                irradiance = kahan_add(irradiance, light * weights[f])
                far_importance += weights[f] * column_total(far.weighted, cluster[f])
                unoccluded_far += weights[f] * column_total(far.unoccluded, cluster[f])
        # A check's target stays while the sum grows with the probability that the old sum has in the new, so the sum at
        # which the next takes its place is drawn at once (P. Efraimidis and P. Spirakis 2006, A-ExpJ).
        target = Ints()
        following = Floats()
        next_change = float(0.0)
        importance = float(0.0)
        unoccluded_near = float(0.0)
        pairs = int(0)
        for check in range(wp.static(CHECKS)):
            target[check] = -1
            following[check] = 0.0
        near = words_type()
        seen = words_type()
        a_part = words_a_part(vpls)
        for word in range((vpls.count + 31) // 32):
            if word % a_part == 0:
                out.unoccluded_prefix[word // a_part, sp] = unoccluded_near
            bits = wp.uint32(0)
            for f in range(wp.static(fuzziness)):
                near[f] = wp.uint32(0)
                if weights[f] > 0.0:
                    near[f] = far.near[cluster[f], word]
                bits |= near[f]
            together = bits_of_warp(bits)
            if together == wp.uint32(0):
                continue
            for f in range(wp.static(fuzziness)):
                seen[f] = known.visibility[cluster[f], word]
            light = wp.vec3(0.0, 0.0, 0.0)
            while together != wp.uint32(0):
                bit = wp.uint32(lowest_bit(together))
                together &= together - wp.uint32(1)
                if ((bits >> bit) & wp.uint32(1)) == wp.uint32(0):
                    continue
                pairs += 1
                whole = unoccluded_irradiance(position, normal, vpls, 32 * word + int(bit))
                amount = brightness(whole)
                if amount > 0.0:
                    share = float(0.0)
                    near_share = float(0.0)
                    for f in range(wp.static(fuzziness)):
                        sees = weights[f] * float((seen[f] >> bit) & wp.uint32(1))
                        share += sees
                        near_share += sees * float((near[f] >> bit) & wp.uint32(1))
                    light += whole * near_share
                    unoccluded_near += amount
                    importance += amount * visibility_weight(share)
                    if importance >= next_change:
                        next_change = FAR_AWAY
                        for check in range(wp.static(CHECKS)):
                            if importance >= following[check]:
                                state = hashed(state)
                                target[check] = 32 * word + int(bit)
                                following[check] = importance / ((float(state) + 1.0) * TO_UNIT)
                            next_change = wp.min(next_change, following[check])
            irradiance = kahan_add(irradiance, light)
        out.irradiance[pixel] = irradiance.total
        out.near_importance[sp] = importance
        out.far_importance[sp] = far_importance
        out.unoccluded_near[sp] = unoccluded_near
        out.unoccluded_far[sp] = unoccluded_far
        out.pairs[sp] = pairs
        for check in range(wp.static(CHECKS)):
            out.target[check, sp] = target[check]

    return fuzzy_shading_kernel


def shade(fuzziness: int, gbuffer: GBuffer, sps: ShadingPoints, known: ClusteredLight, seed: wp.array,
          out: Indirect) -> None:  # fmt: skip
    """Write the indirect light of `sps` into `out`, which draws what to check by `seed` (1,).

    What is `known` is interpolated over the clusters, to F = `fuzziness` of which each SP belongs.
    """
    launch(fuzzy_shading_kernel(fuzziness), sps.capacity, [gbuffer, sps.points, known, seed, out], sps.device)

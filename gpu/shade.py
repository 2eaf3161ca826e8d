"""Indirect light at every shading point from all VPL clusters. Step 6 and Eq. 6 and 9 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import PI, TO_UNIT, hashed
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.sums import Sum, added
from gpu.transfer import brightness, unoccluded
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# Words drawn for each SP, to be checked by rays of its own (gpu.refine).
CHECKS = 4
Words = wp.types.vector(length=CHECKS, dtype=int)


@wp.struct
class Indirect:
    """Indirect light. radiance (pixel,) towards the camera [W/m²/sr], black where there is no SP.

    lost (pixel,): what rounding added to a `radiance` that is gathered run by run, as gpu.sums.Sum;
    low, high (sp,): the least and the most brightness that one of the SP's clusters alone would give it;
    word (CHECKS, sp): words of 32 VPL clusters, each drawn in proportion to the light that the SP gets of them.
    """

    radiance: wp.array[wp.vec3]
    lost: wp.array[wp.vec3]
    low: wp.array[float]
    high: wp.array[float]
    word: wp.array2d[int]


def allocate_indirect(pixels: int, device: wp.Device) -> Indirect:
    """Indirect light of `pixels` pixels."""
    indirect = Indirect()
    indirect.radiance = wp.zeros(pixels, dtype=wp.vec3, device=device)
    indirect.lost = wp.zeros(pixels, dtype=wp.vec3, device=device)
    indirect.low = wp.zeros(pixels, dtype=float, device=device)
    indirect.high = wp.zeros(pixels, dtype=float, device=device)
    indirect.word = wp.zeros((CHECKS, pixels), dtype=int, device=device)
    return indirect


@wp.func
def reflectance(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """Radiance that the camera gets of an SP per irradiance."""
    return wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI


@cache
def shade_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that shades SPs of F = `fuzziness` clusters each."""
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)
    floats_type = wp.types.vector(length=fuzziness, dtype=float)

    @wp.kernel(module="unique", module_options={"fast_math": True})
    def kernel(
        first: int,
        gbuffer: GBuffer,
        sps: wp.array[int],
        sp_count: wp.array[int],
        clusters: SpClusters,
        visibility: wp.array2d[wp.uint32],
        vpls: VplClusters,
        out: Indirect,
    ) -> None:
        """One thread an SP: its light from all VPL clusters, with visibility averaged over its SP clusters."""
        sp = first + wp.tid()
        if sp >= sp_count[0]:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        reflected = reflectance(gbuffer, pixel)
        weights = floats_type()
        # What each of the F clusters adds alone, beyond the VPL clusters that all of them see.
        alone = floats_type()
        for f in range(wp.static(fuzziness)):
            weights[f] = clusters.weight[f, sp]
            alone[f] = 0.0
        drawn = Words()
        state = hashed(wp.uint32(pixel))
        all_agreed = Sum()
        all_disputed = Sum()
        for word in range((vpls.count + 31) // 32):
            words = words_type()
            seen = wp.uint32(0)
            seen_by_all = ~wp.uint32(0)
            for f in range(wp.static(fuzziness)):
                words[f] = visibility[clusters.cluster[f, sp], word]
                if weights[f] > 0.0:
                    seen |= words[f]
                    seen_by_all &= words[f]
            vpl = 32 * word
            agreed = wp.vec3(0.0, 0.0, 0.0)
            disputed = wp.vec3(0.0, 0.0, 0.0)
            while seen != wp.uint32(0):
                if (seen & wp.uint32(1)) != wp.uint32(0):
                    light = unoccluded(position, normal, vpls, vpl)
                    if (seen_by_all & wp.uint32(1)) != wp.uint32(0):
                        agreed += light
                    else:
                        bit = wp.uint32(vpl - 32 * word)
                        amount = brightness(wp.cw_mul(light, reflected))
                        share = float(0.0)
                        for f in range(wp.static(fuzziness)):
                            if ((words[f] >> bit) & wp.uint32(1)) != wp.uint32(0):
                                share += weights[f]
                                alone[f] += amount
                        disputed += light * share
                seen = seen >> wp.uint32(1)
                seen_by_all = seen_by_all >> wp.uint32(1)
                vpl += 1
            all_agreed = added(all_agreed, agreed)
            all_disputed = added(all_disputed, disputed)
            of_word = brightness(agreed + disputed)
            so_far = brightness(all_agreed.total + all_disputed.total)
            for check in range(wp.static(CHECKS)):
                state = hashed(state)
                if float(state) * TO_UNIT * so_far < of_word:
                    drawn[check] = word
        out.radiance[pixel] = wp.cw_mul(reflected, all_agreed.total + all_disputed.total)
        # The nearest cluster comes first; an SP that has none gets no light here and is the first to be refined.
        low = alone[0]
        high = float(0.0)
        for f in range(wp.static(fuzziness)):
            if weights[f] > 0.0:
                low = wp.min(low, alone[f])
                high = wp.max(high, alone[f])
        common = brightness(wp.cw_mul(reflected, all_agreed.total))
        out.low[sp] = common + low
        out.high[sp] = common + high
        for check in range(wp.static(CHECKS)):
            out.word[check, sp] = drawn[check]

    return kernel


def shade(fuzziness: int, gbuffer: GBuffer, pixels: wp.array, count: wp.array, clusters: SpClusters,
          visibility: Visibility, vpls: VplClusters, out: Indirect) -> None:  # fmt: skip
    """Write the indirect light of the SPs at `pixels` (sp,), of which count[0] are valid, into `out`.

    Visibility is interpolated over the SPs' `clusters`, to F = `fuzziness` of which each belongs.
    """
    inputs = [gbuffer, pixels, count, clusters, visibility.words, vpls, out]
    launch(shade_kernel(fuzziness), len(pixels), inputs, pixels.device)


@cache
def gather_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        sps: wp.array[int],
        sp_count: wp.array[int],
        vpls: VplClusters,
        begin: int,
        end: int,
        out: Indirect,
    ) -> None:
        """One thread an SP: adds the light of VPL clusters begin … end − 1, with a shadow ray to each."""
        sp = first + wp.tid()
        if sp >= sp_count[0]:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        geometric = gbuffer.geometric[pixel]
        irradiance = Sum()
        for vpl in range(begin, end):
            light = unoccluded(position, normal, vpls, vpl)
            if brightness(light) > 0.0 and connect(scene, position, geometric, vpls.position[vpl], vpls.normal[vpl]):
                irradiance = added(irradiance, light)
        before = Sum()
        if begin > 0:
            before.total = out.radiance[pixel]
            before.lost = out.lost[pixel]
        after = added(before, wp.cw_mul(reflectance(gbuffer, pixel), irradiance.total))
        out.radiance[pixel] = after.total
        out.lost[pixel] = after.lost

    return kernel


def gather(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, begin: int, end: int,
           out: Indirect) -> None:  # fmt: skip
    """Add the light of VPL clusters begin … end − 1 to `out`, every pair's visibility traced; the first run sets it."""
    inputs = [scene, gbuffer, sps.pixels, sps.count, vpls, begin, end, out]
    launch(gather_kernel(connection(scene)), sps.capacity, inputs, sps.device)

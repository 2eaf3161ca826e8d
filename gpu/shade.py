"""Indirect light at every shading point from all VPL clusters. Step 6 and Eq. 6 and 9 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.grid import FAR_AWAY
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.sums import Sum, added
from gpu.transfer import brightness, unoccluded
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters, out_of_reach

# VPL clusters drawn for each SP, to which it sends rays of its own (gpu.correct).
CHECKS = 5
# The last of them goes to light that none of the SP's clusters sees, the others to what some of them see.
HIDDEN_CHECK = wp.constant(CHECKS - 1)
Floats = wp.types.vector(length=CHECKS, dtype=float)
Ints = wp.types.vector(length=CHECKS, dtype=int)
# How wrong clusters may be that all agree.
LEAST_DOUBT = wp.constant(0.25)
# Of words that none of an SP's clusters sees, one in so many is looked at, and counts as many times.
HIDDEN_WORDS = wp.constant(wp.uint32(4))
WARP = wp.constant(32)
SHADE_KEY = wp.constant(wp.uint32(0x68E31DA4))


@wp.struct
class Indirect:
    """Indirect light at the SPs.

    irradiance (pixel,) [W/m²]; lost (pixel,): what rounding added to an `irradiance` that is gathered run by run, as
    gpu.sums.Sum; target (CHECKS, sp): VPL clusters, each drawn in proportion to its light that is in doubt, −1 for
    none; believed (CHECKS, sp): the share of the SP's clusters that see it; doubted, hidden (sp,): all light in doubt
    that some of them see, and all light that none sees.
    """

    irradiance: wp.array[wp.vec3]
    lost: wp.array[wp.vec3]
    target: wp.array2d[int]
    believed: wp.array2d[float]
    doubted: wp.array[float]
    hidden: wp.array[float]


def allocate_indirect(pixels: int, device: wp.Device) -> Indirect:
    """Indirect light of `pixels` pixels."""
    indirect = Indirect()
    indirect.irradiance = wp.zeros(pixels, dtype=wp.vec3, device=device)
    indirect.lost = wp.zeros(pixels, dtype=wp.vec3, device=device)
    indirect.target = wp.zeros((CHECKS, pixels), dtype=int, device=device)
    indirect.believed = wp.zeros((CHECKS, pixels), dtype=float, device=device)
    indirect.doubted = wp.zeros(pixels, dtype=float, device=device)
    indirect.hidden = wp.zeros(pixels, dtype=float, device=device)
    return indirect


@wp.func
def doubt(share: float) -> float:
    """How far what an SP's clusters believe of a VPL cluster's visibility may be from the truth: its deviation."""
    return LEAST_DOUBT * (1.0 + share)


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
        seed: int,
        out: Indirect,
    ) -> None:
        """One thread an SP: its light from all VPL clusters, with visibility averaged over its SP clusters."""
        sp = first + wp.tid()
        if sp >= sp_count[0]:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        weights = floats_type()
        for f in range(wp.static(fuzziness)):
            weights[f] = clusters.weight[f, sp]
        key = hashed(SHADE_KEY + wp.uint32(seed))
        state = hashed(wp.uint32(pixel) ^ key)
        irradiance = Sum()
        # A check's target stays while the sum grows with the probability that the old sum has in the new, so the sum at
        # which the next takes its place is drawn at once (P. Efraimidis and P. Spirakis 2006, A-ExpJ).
        target = Ints()
        believed = Floats()
        following = Floats()
        next_change = float(0.0)
        doubted = float(0.0)
        hidden = float(0.0)
        for check in range(wp.static(CHECKS)):
            target[check] = -1
            following[check] = 0.0
        for word in range((vpls.count + 31) // 32):
            if out_of_reach(position, normal, vpls, word):
                continue
            words = words_type()
            seen = wp.uint32(0)
            for f in range(wp.static(fuzziness)):
                words[f] = visibility[clusters.cluster[f, sp], word]
                if weights[f] > 0.0:
                    seen |= words[f]
            # Neighbours leave the same words out, so that a warp's threads do.
            times = float(1.0)
            if seen == wp.uint32(0):
                if hashed(wp.uint32(sp // WARP) ^ hashed(key + wp.uint32(word))) % HIDDEN_WORDS != wp.uint32(0):
                    continue
                times = float(HIDDEN_WORDS)
            light = wp.vec3(0.0, 0.0, 0.0)
            for vpl in range(32 * word, wp.min(32 * word + 32, vpls.count)):
                whole = unoccluded(position, normal, vpls, vpl)
                amount = brightness(whole)
                if amount > 0.0:
                    share = float(0.0)
                    for f in range(wp.static(fuzziness)):
                        share += weights[f] * float((words[f] >> wp.uint32(vpl - 32 * word)) & wp.uint32(1))
                    light += whole * share
                    if share > 0.0:
                        doubted += amount * doubt(share)
                        if doubted >= next_change:
                            next_change = FAR_AWAY
                            for check in range(wp.static(CHECKS - 1)):
                                if doubted >= following[check]:
                                    state = hashed(state)
                                    target[check] = vpl
                                    believed[check] = share
                                    following[check] = doubted / ((float(state) + 1.0) * TO_UNIT)
                                next_change = wp.min(next_change, following[check])
                    else:
                        hidden += amount * times
                        if hidden >= following[HIDDEN_CHECK]:
                            state = hashed(state)
                            target[HIDDEN_CHECK] = vpl
                            believed[HIDDEN_CHECK] = 0.0
                            following[HIDDEN_CHECK] = hidden / ((float(state) + 1.0) * TO_UNIT)
            irradiance = added(irradiance, light)
        out.irradiance[pixel] = irradiance.total
        out.doubted[sp] = doubted
        out.hidden[sp] = hidden
        for check in range(wp.static(CHECKS)):
            out.target[check, sp] = target[check]
            out.believed[check, sp] = believed[check]

    return kernel


def shade(fuzziness: int, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters, visibility: Visibility,
          vpls: VplClusters, seed: int, out: Indirect) -> None:  # fmt: skip
    """Write the indirect light of `sps` into `out`, which draws what to check by `seed`.

    Visibility is interpolated over the SPs' `clusters`, to F = `fuzziness` of which each belongs.
    """
    inputs = [gbuffer, sps.pixels, sps.count, clusters, visibility.words, vpls, seed, out]
    launch(shade_kernel(fuzziness), sps.capacity, inputs, sps.device)


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
            before.total = out.irradiance[pixel]
            before.lost = out.lost[pixel]
        after = added(before, irradiance.total)
        out.irradiance[pixel] = after.total
        out.lost[pixel] = after.lost

    return kernel


def gather(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, begin: int, end: int,
           out: Indirect) -> None:  # fmt: skip
    """Add the light of VPL clusters begin … end − 1 to `out`, every pair's visibility traced; the first run sets it."""
    inputs = [scene, gbuffer, sps.pixels, sps.count, vpls, begin, end, out]
    launch(gather_kernel(connection(scene)), sps.capacity, inputs, sps.device)

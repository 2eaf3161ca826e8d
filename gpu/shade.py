"""Indirect light at every shading point from all VPL clusters. Step 6 and Eq. 6 and 9 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.device import allocate, launch
from gpu.gbuffer import GBuffer
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import PI
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# A cluster whose disk has more area than this times the squared distance is shaded member by member.
UNFOLD_SHARE = wp.constant(0.1)


@wp.struct
class Indirect:
    """Indirect light. radiance (pixel,) towards the camera [W/m²/sr], black where there is no SP.

    low, high (sp,): the least and the most luminance that one of the SP's clusters alone would give it.
    """

    radiance: wp.array[wp.vec3]
    low: wp.array[float]
    high: wp.array[float]


def allocate_indirect(pixels: int, device: wp.Device) -> Indirect:
    """Indirect light of `pixels` pixels."""
    indirect: Indirect = allocate(Indirect, pixels, device)
    return indirect


@wp.func
def disk_transfer(way: wp.vec3, normal: wp.vec3, disk_normal: wp.vec3, area: float) -> float:
    """Share of a disk light's flux that arrives per area at an unoccluded point `-way` from it: form factor over area.

    cosθ·cosθ′ / (π·d² + A), which is bounded by 1/A, where point lights' 1/d² makes bright spots.
    """
    squared = wp.length_sq(way)
    facing = wp.dot(way, normal)
    leaving = -wp.dot(way, disk_normal)
    if facing <= 0.0 or leaving <= 0.0:
        return 0.0
    return facing * leaving / (squared * (PI * squared + area))


@wp.func
def unoccluded(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int) -> wp.vec3:
    """Irradiance at a point from a VPL cluster that nothing hides [W/m²].

    Near a cluster its one disk would be too coarse and too dim, so its members count one by one there.
    """
    way = vpls.position[cluster] - position
    area = vpls.area[cluster]
    if area <= UNFOLD_SHARE * wp.length_sq(way):
        return vpls.flux[cluster] * disk_transfer(way, normal, vpls.normal[cluster], area)
    irradiance = wp.vec3(0.0, 0.0, 0.0)
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    area = area / float(end - begin)
    for member in range(begin, end):
        way = vpls.members.position[member] - position
        share = disk_transfer(way, normal, vpls.members.normal[member], area)
        irradiance += vpls.members.flux[member] * share
    return irradiance


@wp.func
def reflectance(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """Radiance that the camera gets of an SP per irradiance."""
    return wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI


@wp.func
def brightness(radiance: wp.vec3) -> float:
    """One number for how bright a radiance is."""
    return (radiance[0] + radiance[1] + radiance[2]) / 3.0


@cache
def shade_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that shades SPs of F = `fuzziness` clusters each."""
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)
    floats_type = wp.types.vector(length=fuzziness, dtype=float)

    @wp.kernel(module="unique")
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
        agreed = wp.vec3(0.0, 0.0, 0.0)
        disputed = wp.vec3(0.0, 0.0, 0.0)
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
        out.radiance[pixel] = wp.cw_mul(reflected, agreed + disputed)
        low = float(1.0e30)
        high = float(0.0)
        for f in range(wp.static(fuzziness)):
            if weights[f] > 0.0:
                low = wp.min(low, alone[f])
                high = wp.max(high, alone[f])
        common = brightness(wp.cw_mul(reflected, agreed))
        out.low[sp] = common + low
        out.high[sp] = common + high

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
        irradiance = wp.vec3(0.0, 0.0, 0.0)
        for vpl in range(begin, end):
            light = unoccluded(position, normal, vpls, vpl)
            if brightness(light) > 0.0 and connect(scene, position, geometric, vpls.position[vpl], vpls.normal[vpl]):
                irradiance += light
        out.radiance[pixel] += wp.cw_mul(reflectance(gbuffer, pixel), irradiance)

    return kernel


def gather(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, begin: int, end: int,
           out: Indirect) -> None:  # fmt: skip
    """Add the light of VPL clusters begin … end − 1 to `out`, every pair's visibility traced."""
    inputs = [scene, gbuffer, sps.pixels, sps.count, vpls, begin, end, out]
    launch(gather_kernel(connection(scene)), sps.capacity, inputs, sps.device)

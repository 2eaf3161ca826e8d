"""Indirect light at every shading point from all VPL clusters. Step 6 and Eq. 6 and 9 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.rays import connected
from gpu.resident import ResidentScene, SceneData
from gpu.sampling import PI
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# A cluster whose disk has more area than this times the squared distance is shaded member by member.
UNFOLD_SHARE = wp.constant(0.1)


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


@cache
def shade_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that shades SPs of F = `fuzziness` clusters each."""
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)
    weights_type = wp.types.vector(length=fuzziness, dtype=float)

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        gbuffer: GBuffer,
        sps: wp.array[int],
        sp_count: wp.array[int],
        clusters: SpClusters,
        visibility: wp.array2d[wp.uint32],
        vpls: VplClusters,
        radiance: wp.array[wp.vec3],
    ) -> None:
        """One thread an SP: adds its indirect light to radiance (pixel,) [W/m²/sr]."""
        sp = first + wp.tid()
        if sp >= sp_count[0]:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        weights = weights_type()
        for f in range(wp.static(fuzziness)):
            weights[f] = clusters.weight[f, sp]
        irradiance = wp.vec3(0.0, 0.0, 0.0)
        for word in range((vpls.count + 31) // 32):
            words = words_type()
            seen = wp.uint32(0)
            for f in range(wp.static(fuzziness)):
                words[f] = visibility[clusters.cluster[f, sp], word]
                seen |= words[f]
            bit = int(0)
            while seen != wp.uint32(0):
                if (seen & wp.uint32(1)) != wp.uint32(0):
                    vpl = word * 32 + bit
                    share = float(0.0)
                    for f in range(wp.static(fuzziness)):
                        share += weights[f] * float((words[f] >> wp.uint32(bit)) & wp.uint32(1))
                    irradiance += unoccluded(position, normal, vpls, vpl) * share
                seen = seen >> wp.uint32(1)
                bit += 1
        reflected = wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI
        radiance[pixel] += wp.cw_mul(reflected, irradiance)

    return kernel


def shade(fuzziness: int, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters, visibility: Visibility,
          vpls: VplClusters, radiance: wp.array) -> None:  # fmt: skip
    """Add the indirect light of all `sps` to `radiance` (pixel,), with visibility interpolated over their clusters."""
    inputs = [gbuffer, sps.pixels, sps.count, clusters, visibility.words, vpls, radiance]
    launch(shade_kernel(fuzziness), sps.capacity, inputs, sps.device)


@wp.kernel
def gather_kernel(first: int, scene: SceneData, gbuffer: GBuffer, sps: wp.array[int], sp_count: wp.array[int],
                  vpls: VplClusters, begin: int, end: int, radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: adds the light of VPL clusters begin … end − 1, with a shadow ray to each, to radiance."""
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
        if light[0] + light[1] + light[2] > 0.0 and connected(
            scene, position, geometric, vpls.position[vpl], vpls.normal[vpl]
        ):
            irradiance += light
    reflected = wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI
    radiance[pixel] += wp.cw_mul(reflected, irradiance)


def gather(resident: ResidentScene, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters,
           begin: int, end: int, radiance: wp.array) -> None:  # fmt: skip
    """Add the light of VPL clusters begin … end − 1 to `radiance` (pixel,), every pair's visibility traced."""
    inputs = [scene, gbuffer, sps.pixels, sps.count, vpls, begin, end, radiance]
    launch(gather_kernel, sps.capacity, inputs, resident.device)

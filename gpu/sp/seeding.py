"""SP clusters for shading points that others serve badly: systematic sampling of the SPs in proportion to deficit.

In a frame from nothing, the share of the clusters that is kept back from k-means goes where the deficit is greatest. In
a walk, deficits tell how many clusters a place lacks beside those that are kept from the frame before.
"""

import warp as wp

from gpu.core.search import upper_bound
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.sp.budget import ClusterBudget, SpClusterParameters, cluster_spacing, lacking_of, room_of
from gpu.sp.sp_clusters import ClusterWork, SpClusters


@wp.func
def drawn_sp(deficit_sums: wp.array[int], count: int, index: int, number: int) -> int:
    """The SP that draw `index` of `number` falls on, −1 if an earlier one does.

    deficit_sums: the running sum of the deficits of `count` SPs.
    """
    if count == 0:
        return -1
    total = wp.int64(deficit_sums[count - 1])
    if total == wp.int64(0):
        return -1
    target = (wp.int64(2 * index + 1) * total) / wp.int64(2 * number)
    before = (wp.int64(2 * index - 1) * total) / wp.int64(2 * number)
    sp = upper_bound(deficit_sums, count - 1, int(target))
    below = wp.int64(0)
    if sp > 0:
        below = wp.int64(deficit_sums[sp - 1])
    if index > 0 and before >= below:
        return -1
    return sp


@wp.func
def set_representative(
    gbuffer: GBuffer, pixel: int, spacing: float, cluster: int, clusters: SpClusters, work: ClusterWork
) -> None:
    """Make the SP of `pixel` the representative of `cluster`."""
    work.pixels[cluster] = pixel
    clusters.position[cluster] = gbuffer.position[pixel]
    clusters.normal[cluster] = gbuffer.normal[pixel]
    clusters.spacing[cluster] = spacing


@wp.kernel
def seed_extra_kernel(first: int, gbuffer: GBuffer, points: PointList, deficit_sums: wp.array[int],
                      budget: ClusterBudget, work: ClusterWork, clusters: SpClusters) -> None:  # fmt: skip
    """One thread one of the clusters that follow those of k-means: takes its SP.

    deficit_sums (sp,): the running sum of deficits.
    """
    index = first + wp.tid()
    extra = budget.wanted[0] - budget.base[0]
    if index >= extra:
        return
    cluster = budget.base[0] + index
    clusters.spacing[cluster] = 0.0
    sp = drawn_sp(deficit_sums, points.count[0], index, extra)
    if sp >= 0:
        pixel = points.pixels[sp]
        spacing = cluster_spacing(gbuffer, pixel, points, budget)
        set_representative(gbuffer, pixel, spacing, cluster, clusters, work)


@wp.kernel
def fill_unused_kernel(first: int, gbuffer: GBuffer, points: PointList, deficit_sums: wp.array[int],
                       budget: ClusterBudget, chosen: SpClusterParameters, work: ClusterWork,
                       clusters: SpClusters) -> None:  # fmt: skip
    """One thread a cluster: one that is unused takes an SP, as long as clusters are lacking, and some may be new.

    It serves at once: it is there for an SP that may not be seen before the next frame. deficit_sums (sp,): the running
    sum of deficits.
    """
    cluster = first + wp.tid()
    count = points.count[0]
    index = work.unused_prefix[cluster] - 1
    if count == 0 or work.unused[cluster] == 0:
        return
    room = wp.min(room_of(work.unused_prefix, budget, chosen), budget.max_new[0])
    number = wp.min(room, lacking_of(deficit_sums, points, budget))
    if index >= number:
        return
    sp = drawn_sp(deficit_sums, count, index, number)
    if sp >= 0:
        pixel = points.pixels[sp]
        clusters.serving[cluster] = 1
        spacing = cluster_spacing(gbuffer, pixel, points, budget)
        set_representative(gbuffer, pixel, spacing, cluster, clusters, work)

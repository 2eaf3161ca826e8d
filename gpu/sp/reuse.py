"""Representatives of SP clusters that are kept from the frame before, and with them their visibility.

Temporal coherence, which the 2022 paper leaves to future work and the 2009 paper has for its gather points: a
representative is a point of the scene, so it and what it sees stay true while the lights do. It is kept as long as the
camera sees its surface where it is. As the view makes its spacing, not the frame in which it was found, those of a
surface that moves away come too close to each other: of two such, one goes.
"""

import warp as wp

from gpu.clustering.grid import (
    ClusteringParameters,
    Representatives,
    bucket_of,
    cell_at,
    cells_per_unit,
    entry_at,
    separation,
)
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.radix_sort import running_total
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, pixel_of
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.sampling.sobol import hashed
from gpu.sp.budget import SP_CLUSTER_PARAMETERS, ClusterBudget, SpClusterParameters, cluster_spacing, staying_of
from gpu.sp.sp_clusters import ClusterWork, KeptClusters, SpClusters

CORNERS = 8  # of the cube around a representative that holds what may crowd it


@wp.func
def is_visible_at(gbuffer: GBuffer, pixel: int, position: wp.vec3, normal: wp.vec3, spacing: float, near: float,
                  chosen: ClusteringParameters) -> bool:  # fmt: skip
    """Whether a pixel's SP is of the surface that has a point at `position`, and less than a spacing away.

    A pixel shows one point of the folds and edges within it, so one nearer than `near` spacings of pixels counts, too.
    """
    way = gbuffer.position[pixel] - position
    there = gbuffer.normal[pixel]
    plane = wp.max(wp.abs(wp.dot(way, normal)), wp.abs(wp.dot(way, there)))
    alike = wp.dot(there, normal) > chosen.normal_threshold
    beside = wp.length(way) < spacing and chosen.plane_weight * plane < spacing
    return (alike and beside) or wp.length(way) < near * gbuffer.spacing[pixel]


@wp.kernel
def keep_visible_kernel(first: int, cameras: wp.array[CameraData], image: ImageSize, gbuffer: GBuffer,
                        points: PointList, budget: ClusterBudget, chosen: SpClusterParameters, clusters: SpClusters,
                        work: ClusterWork) -> None:  # fmt: skip
    """One thread a cluster: its spacing in this view, 0 where its representative's surface is not seen.

    Its own pixel must show it: one hidden behind slats, which neighbours show, sees other light than what is seen.
    Those that serve no SP are in vain; from here on none serves until an SP finds it.
    """
    cluster = first + wp.tid()
    work.spacing[cluster] = 0.0
    work.crowded[cluster] = 0
    served = clusters.serving[cluster]
    clusters.serving[cluster] = 0
    if clusters.spacing[cluster] <= 0.0 or served == 0:
        return
    position = clusters.position[cluster]
    place = pixel_of(cameras[0], position, image)
    if place[0] < 0 or place[1] < 0 or place[0] >= image.width or place[1] >= image.height:
        return
    pixel = place[1] * image.width + place[0]
    if gbuffer.face[pixel] != NO_HIT:
        spacing = cluster_spacing(gbuffer, pixel, points, budget)
        normal = clusters.normal[cluster]
        if is_visible_at(gbuffer, pixel, position, normal, spacing, chosen.same_place, clusters.alike):
            work.spacing[cluster] = spacing


@wp.kernel
def mark_close_pairs_kernel(first: int, budget: ClusterBudget, crowded: float, representatives: Representatives,
                            work: ClusterWork) -> None:  # fmt: skip
    """One thread a corner of a cluster's surroundings: marks it where one there is too near to keep both.

    Of the two, that of the higher rank is marked, whoever writes it: chance decides, but always alike. Cells, of the
    grid of the frame before, are wider than that, so at most two of them on each axis can hold it, and each has a
    corner in it. Where counts have just fallen by much, some stay for a frame more.
    crowded: nearer is too near [accepted distances].
    """
    index = first + wp.tid()
    cluster = index // CORNERS
    corner = index % CORNERS
    if work.spacing[cluster] <= 0.0:
        return
    position = representatives.position[cluster]
    normal = representatives.normal[cluster]
    level = representatives.level[cluster]
    reach = crowded * budget.accepted_distance[0] * work.spacing[cluster]
    rank = hashed(wp.uint32(cluster))
    scale = cells_per_unit(level)
    cell = cell_at(position - wp.vec3(reach, reach, reach), scale)
    highest = cell_at(position + wp.vec3(reach, reach, reach), scale)
    for axis in range(3):
        if (corner >> axis) % 2 == 1:
            if highest[axis] == cell[axis]:
                return  # another corner's cell
            cell[axis] = highest[axis]
    bucket = bucket_of(cell, level, representatives.buckets)
    for place in range(representatives.starts[bucket], representatives.starts[bucket + 1]):
        other = entry_at(representatives, place)
        alike = wp.dot(other.normal, normal) > representatives.chosen.normal_threshold
        if alike and separation(representatives.chosen, position, normal, other.position, other.normal) < reach:
            number = other.cluster
            if number != cluster and work.spacing[number] > 0.0 and hashed(wp.uint32(number)) < rank:
                work.crowded[cluster] = 1
                return


@wp.kernel
def drop_close_kernel(first: int, work: ClusterWork, spacing: wp.array[float]) -> None:
    """One thread a cluster: keeps it with its `spacing` (cluster,) in this view if it is seen and none is too near."""
    cluster = first + wp.tid()
    kept = work.spacing[cluster] > 0.0 and work.crowded[cluster] == 0
    spacing[cluster] = wp.where(kept, work.spacing[cluster], 0.0)
    work.unused[cluster] = wp.where(kept, 0, 1)
    work.pixels[cluster] = -1


@wp.kernel
def drop_surplus_kernel(first: int, budget: ClusterBudget, chosen: SpClusterParameters, unused_prefix: wp.array[int],
                        spacing: wp.array[float]) -> None:  # fmt: skip
    """One thread a cluster: where too many are in use, some lose their `spacing` (cluster,), evenly many of all.

    unused_prefix (cluster,): the running number of those that are not in use.
    """
    cluster = first + wp.tid()
    places = unused_prefix.shape[0]
    used = wp.int64(places - unused_prefix[places - 1])
    stay = wp.int64(staying_of(int(used), budget, chosen))
    if used == stay or spacing[cluster] <= 0.0:
        return
    before = wp.int64(cluster - unused_prefix[cluster])
    if (before + wp.int64(1)) * stay / used == before * stay / used:
        spacing[cluster] = 0.0


def keep_representatives(kept: KeptClusters, clusters: SpClusters, camera: wp.array, size: tuple[int, int],
                         gbuffer: GBuffer, points: PointList, work: ClusterWork) -> None:  # fmt: skip
    """Keep of the last frame's representatives, those of `clusters`, what is still good; free the others.

    camera: (1,) CameraData of this frame, whose `gbuffer` has `size`. All of `work` is written.
    """
    count, device = len(work.spacing), work.spacing.device
    budget, chosen, representatives = kept.budget, SP_CLUSTER_PARAMETERS, kept.grid.data
    inputs = [camera, image_size(size), gbuffer, points, budget, chosen, clusters, work]
    launch(keep_visible_kernel, count, inputs, device)
    launch(mark_close_pairs_kernel, CORNERS * count, [budget, chosen.crowded, representatives, work], device)
    launch(drop_close_kernel, count, [work, clusters.spacing], device)
    running_total(work.unused, work.unused_prefix)
    launch(drop_surplus_kernel, count, [budget, chosen, work.unused_prefix, clusters.spacing], device)

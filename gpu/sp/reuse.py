"""Representatives of SP clusters that are kept from the frame before, and with them their visibility.

Temporal coherence, which the 2022 paper leaves to future work and the 2009 paper has for its gather points: a
representative is a point of the scene, so it and what it sees stay true while the lights do. It is kept as long as the
camera sees its surface where it is. As the view makes its spacing, not the frame in which it was found, those of a
surface that moves away come too close to each other: of two such, one goes.
"""

import warp as wp

from gpu.clustering.grid import (
    NORMAL_THRESHOLD,
    PLANE_WEIGHT,
    Representatives,
    bucket_of,
    cell_at,
    cells_per_unit,
    entry_at,
    separation,
)
from gpu.core.device import launch
from gpu.core.radix_sort import running_total
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, pixel_of
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.sampling.sobol import hashed
from gpu.sp.seeding import staying_of

# Nearer than this share of the distance that is good enough, two representatives are one too many. As new ones are
# added for SPs that are farther than that from all, a view that rests comes to rest.
CROWDED = wp.constant(0.93)
CORNERS = 8  # of the cube around a representative that holds what may crowd it
# In spacings of pixels: nearer than this, a representative is seen where its pixel's SP is, whatever its normal.
SAME_PLACE = wp.constant(1.5)


@wp.func
def is_visible_at(gbuffer: GBuffer, pixel: int, position: wp.vec3, normal: wp.vec3, spacing: float) -> bool:
    """Whether a pixel's SP is of the surface that has a point at `position`, and less than a spacing away.

    A pixel shows one point of the folds and edges within it, so one at the same place counts, too.
    """
    way = gbuffer.position[pixel] - position
    there = gbuffer.normal[pixel]
    plane = wp.max(wp.abs(wp.dot(way, normal)), wp.abs(wp.dot(way, there)))
    alike = wp.dot(there, normal) > NORMAL_THRESHOLD and wp.length(way) < spacing and PLANE_WEIGHT * plane < spacing
    return alike or wp.length(way) < SAME_PLACE * gbuffer.spacing[pixel]


@wp.kernel
def keep_kernel(first: int, cameras: wp.array[CameraData], width: int, height: int, gbuffer: GBuffer,
                sp_count: wp.array[int], spacing_scale: wp.array[float], representatives: Representatives,
                serving: wp.array[int], spacings: wp.array[float], crowded: wp.array[int]) -> None:  # fmt: skip
    """One thread a cluster: its spacing in this view, 0 where its representative's surface is not seen.

    Its own pixel must show it: one hidden behind slats, which neighbours show, sees other light than what is seen.
    serving (cluster,): 1 for those that were the nearest of an SP, of which the others are in vain; becomes 0, as does
    crowded (cluster,).
    """
    cluster = first + wp.tid()
    spacings[cluster] = 0.0
    crowded[cluster] = 0
    served = serving[cluster]
    serving[cluster] = 0
    if representatives.spacing[cluster] <= 0.0 or served == 0:
        return
    position = representatives.position[cluster]
    place = pixel_of(cameras[0], position, width, height)
    if place[0] < 0 or place[1] < 0 or place[0] >= width or place[1] >= height:
        return
    pixel = place[1] * width + place[0]
    if gbuffer.face[pixel] != NO_HIT:
        spacing = gbuffer.spacing[pixel] * wp.sqrt(float(sp_count[0])) * spacing_scale[0]
        if is_visible_at(gbuffer, pixel, position, representatives.normal[cluster], spacing):
            spacings[cluster] = spacing


@wp.kernel
def mark_close_pairs_kernel(first: int, spacings: wp.array[float], accepted_distance: wp.array[float], representatives:
Representatives,
                 crowded: wp.array[int]) -> None:  # fmt: skip
    """One thread a corner of a cluster's surroundings: whether one there is too near to keep both.

    Cells are wider than that, so at most two of them on each axis can hold it, and each has a corner in it. Where
    counts have just fallen by much, some stay for a frame more.
    crowded (cluster,): becomes 1 where one that stays has a lower rank, whoever writes it. The grid is still that of
    the frame before.
    """
    index = first + wp.tid()
    cluster = index // CORNERS
    corner = index % CORNERS
    if spacings[cluster] <= 0.0:
        return
    position = representatives.position[cluster]
    normal = representatives.normal[cluster]
    level = representatives.level[cluster]
    reach = CROWDED * accepted_distance[0] * spacings[cluster]
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
        alike = wp.dot(other.normal, normal) > NORMAL_THRESHOLD
        if alike and separation(position, normal, other.position, other.normal) < reach:
            number = other.cluster
            if number != cluster and spacings[number] > 0.0 and hashed(wp.uint32(number)) < rank:
                crowded[cluster] = 1
                return


@wp.kernel
def drop_close_kernel(first: int, spacings: wp.array[float], crowded: wp.array[int], representatives: Representatives,
                pixels: wp.array[int]) -> None:  # fmt: skip
    """One thread a cluster: keeps it with its spacing in this view, unless it is seen no more or another is too near.

    Of two that are too near, chance decides, but always alike.
    """
    cluster = first + wp.tid()
    pixels[cluster] = -1
    representatives.spacing[cluster] = wp.where(crowded[cluster] == 1, 0.0, spacings[cluster])


@wp.kernel
def unused_kernel(first: int, representatives: Representatives, unused: wp.array[int]) -> None:
    """One thread a cluster: 1 where it has no representative, else 0."""
    cluster = first + wp.tid()
    unused[cluster] = wp.where(representatives.spacing[cluster] > 0.0, 0, 1)


@wp.kernel
def drop_kernel(first: int, wanted: wp.array[int], unused: wp.array[int], accepted_distance: wp.array[float],
                representatives: Representatives) -> None:  # fmt: skip
    """One thread a cluster: where more than `wanted` (1,) are in use, somewhat fewer stay, evenly many of all.

    free (cluster,): the running number of those that are not in use; good (1,): the distance that is good enough, at
    its most of which there is to be room, too.
    """
    cluster = first + wp.tid()
    places = unused.shape[0]
    used = wp.int64(places - unused[places - 1])
    stay = wp.int64(staying_of(int(used), wanted[0], accepted_distance[0]))
    if used == stay or representatives.spacing[cluster] <= 0.0:
        return
    before = wp.int64(cluster - unused[cluster])
    if (before + wp.int64(1)) * stay / used == before * stay / used:
        representatives.spacing[cluster] = 0.0


def keep(camera: wp.array, size: tuple[int, int], gbuffer: GBuffer, sps: ShadingPoints, spacing_scale: wp.array,
         accepted_distance: wp.array, representatives: Representatives, serving: wp.array, spacings: wp.array, crowded:
         wp.array, pixels: wp.array) -> None:  # fmt: skip
    """Keep of the last frame's `representatives` those that are still good; the others become free.

    camera: (1,) CameraData of this frame, whose `gbuffer` has `size`; spacing_scale (1,): from a pixel's spacing and
    the square root of the SPs' count to that of clusters; good (1,): the distance from an SP that is good enough
    [spacings]; serving (cluster,): 1 for the nearest of an SP in the last frame, becomes 0; spacings, crowded
    (cluster,): for the work; pixels (cluster,): becomes −1.
    """
    count, device = len(spacings), sps.device
    inputs = [camera, *size, gbuffer, sps.count, spacing_scale, representatives, serving, spacings, crowded]
    launch(keep_kernel, count, inputs, device)
    launch(mark_close_pairs_kernel, CORNERS * count, [spacings, accepted_distance, representatives, crowded], device)
    launch(drop_close_kernel, count, [spacings, crowded, representatives, pixels], device)


def drop(
    representatives: Representatives,
    wanted: wp.array,
    accepted_distance: wp.array,
    unused: wp.array,
    unused_prefix: wp.array,
) -> None:
    """Of more `representatives` in use than `wanted` (1,) keep somewhat fewer, evenly many of all.

    good (1,): the distance from an SP that is good enough [spacings], at its most of which there is to be room, too;
    free (cluster,): becomes 1 for those that were not in use before, else 0; frees (cluster,): the running sum of that.
    """
    count, device = len(unused), unused.device
    launch(unused_kernel, count, [representatives, unused], device)
    running_total(unused, unused_prefix)
    launch(drop_kernel, count, [wanted, unused_prefix, accepted_distance, representatives], device)

"""SP clusters for shading points that others serve badly: systematic sampling of the SPs in proportion to need.

Need has two scales. DEFICIT_IN_FRAME tells how badly a frame's SPs are served; the share of the clusters that is kept
back from k-means goes where it is greatest. DEFICIT_TO_FILL tells how many clusters a place lacks beside those that are
kept from the frame before: an SP that needs one wholly counts as its share of all of them.
"""

import warp as wp

from gpu.clustering.grid import Representatives
from gpu.core.search import upper_bound
from gpu.gbuffer.gbuffer import GBuffer


@wp.struct
class DeficitScale:
    """What an SP needs that is `d` spacings from its nearest representative: steps · (d − good), from 0 to `most`.

    good: 1 for DEFICIT_IN_FRAME, for DEFICIT_TO_FILL what a walk has come to. unlike: if none near has a like normal,
    at least; unserved: if there is none near at all.
    """

    steps: float
    most: int
    unlike: int
    unserved: int


def _deficit_scale(steps: float, most: int, unlike: int, unserved: int) -> DeficitScale:
    scale = DeficitScale()
    scale.steps, scale.most, scale.unlike, scale.unserved = steps, most, unlike, unserved
    return scale


UNSERVED_DEFICIT = wp.constant(1023)
DEFICIT_IN_FRAME = _deficit_scale(16.0, 255, 0, int(UNSERVED_DEFICIT))
# Need of an SP that lacks its whole share of a cluster.
WHOLE_DEFICIT = wp.constant(16)
# Where few are free, they are for SPs that are far from all, and most for those that none serves.
DEFICIT_TO_FILL = _deficit_scale(64.0, 2 * int(WHOLE_DEFICIT), 2 * int(WHOLE_DEFICIT), 8 * int(WHOLE_DEFICIT))

# In spacings, the distance of an SP from its nearest representative that is good enough: to begin with, for a walk
# adapts it until a share of the clusters stays free. Else flat surfaces take up all, and none are left for what comes
# into view: with 0.8 at most, so it was in a Cornell box that a camera turned back to, whose block then had the light
# of its other side, and its errors were 10 to 20 times those of a frame from nothing.
ACCEPTED_DISTANCE = 0.65
MIN_ACCEPTED_DISTANCE, MAX_ACCEPTED_DISTANCE = wp.constant(0.4), wp.constant(1.2)
# PowerCdf of the clusters; as nothing changes between least and most, a view that rests comes to rest.
LEAST_FREE, FREE, MOST_FREE = wp.constant(0.01), wp.constant(0.02), wp.constant(0.04)
# In a frame, as a share of it.
MOST_CHANGE = wp.constant(0.03)
# Of a walk that goes on with another number of clusters than before, at most this share is new in a frame until nothing
# is lacking: new ones trace rays, and frames are to take alike.
MOST_NEW = wp.constant(0.0625)


@wp.func
def deficit_of(scale: DeficitScale, accepted_distance: float, spacings: float, alike: bool) -> int:
    """The need of an SP whose nearest representative is so many spacings away; alike: their normals are.

    good: the distance that is good enough.
    """
    return wp.max(
        wp.clamp(int(scale.steps * (spacings - accepted_distance)), 0, scale.most), wp.where(alike, 0, scale.unlike)
    )


@wp.func
def drawn_sp(totals: wp.array[int], count: int, index: int, number: int) -> int:
    """The SP that draw `index` of `number` falls on, −1 if an earlier one does; totals: the running sum of need."""
    if count == 0:
        return -1
    total = wp.int64(totals[count - 1])
    if total == wp.int64(0):
        return -1
    target = (wp.int64(2 * index + 1) * total) / wp.int64(2 * number)
    before = (wp.int64(2 * index - 1) * total) / wp.int64(2 * number)
    sp = upper_bound(totals, count - 1, int(target))
    below = wp.int64(0)
    if sp > 0:
        below = wp.int64(totals[sp - 1])
    if index > 0 and before >= below:
        return -1
    return sp


@wp.func
def set_representative(
    gbuffer: GBuffer, pixel: int, spacing: float, cluster: int, representatives: Representatives
) -> None:
    """Make the SP of `pixel` the representative of `cluster`."""
    representatives.position[cluster] = gbuffer.position[pixel]
    representatives.normal[cluster] = gbuffer.normal[pixel]
    representatives.spacing[cluster] = spacing


@wp.kernel
def extra_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], sp_count: wp.array[int], totals: wp.array[int],
                 spacing_scale: wp.array[float], base: wp.array[int], wanted: wp.array[int],
                 representatives: Representatives, pixels: wp.array[int]) -> None:  # fmt: skip
    """One thread one of `wanted` (1,) clusters from `base` (1,) on, those before being of k-means: takes its SP.

    totals: the running sum of need; spacing_scale (1,): as in gpu.sp.reuse; pixels (cluster,): where the
    representatives are.
    """
    index = first + wp.tid()
    extra = wanted[0] - base[0]
    if index >= extra:
        return
    cluster = base[0] + index
    representatives.spacing[cluster] = 0.0
    sp = drawn_sp(totals, sp_count[0], index, extra)
    if sp >= 0:
        pixels[cluster] = sps[sp]
        spacing = gbuffer.spacing[sps[sp]] * wp.sqrt(float(sp_count[0])) * spacing_scale[0]
        set_representative(gbuffer, sps[sp], spacing, cluster, representatives)


@wp.func
def staying_of(used: int, wanted: int, accepted_distance: float) -> int:
    """Of `used` clusters, how many stay where `wanted` are to be: where some have to go, there is room for new ones.

    Else what comes into view in that frame has none, and the light of others. So it is, too, where a few clusters have
    much to cover, and the distance that is `accepted_distance` enough can grow no more.
    """
    if used > wanted or accepted_distance >= MAX_ACCEPTED_DISTANCE:
        return wp.min(used, wanted - int(MOST_NEW * float(wanted)))
    return used


@wp.func
def room_of(unused: wp.array[int], wanted: int, accepted_distance: float) -> int:
    """How many of `wanted` clusters may be new; free (cluster,): as in fill_kernel; good: as in staying_of."""
    places = unused.shape[0]
    used = places - unused[places - 1]
    return wp.min(wanted - staying_of(used, wanted, accepted_distance), unused[places - 1])


@wp.func
def lacking_of(totals: wp.array[int], count: int, clusters: int) -> int:
    """How many more clusters `count` SPs need; totals: the running sum of need, by which they lack a share of all."""
    return int(wp.int64(totals[count - 1]) * wp.int64(clusters) / (wp.int64(count) * wp.int64(WHOLE_DEFICIT)))


@wp.kernel
def fill_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], sp_count: wp.array[int], totals: wp.array[int],
                spacing_scale: wp.array[float], wanted: wp.array[int], unused: wp.array[int], accepted_distance:
                wp.array[float], most: wp.array[int], representatives: Representatives, pixels: wp.array[int],
                serving: wp.array[int]) -> None:  # fmt: skip
    """One thread a cluster: one that is free takes an SP, as long as clusters are lacking, and at most `most` (1,) do.

    totals: the running sum of need, by which SPs lack their share of all `wanted` (1,) clusters; spacing_scale (1,): as
    in gpu.sp.reuse; free (cluster,): the running number of those that were free before too many were dropped;
    good (1,): the distance that is good enough;
    pixels (cluster,): where new representatives are; serving (cluster,): 1 for them, which are there for an SP that may
    not see them before the next frame.
    """
    cluster = first + wp.tid()
    count = sp_count[0]
    index = unused[cluster] - 1
    if count == 0 or index < 0 or (cluster > 0 and unused[cluster - 1] == unused[cluster]):
        return
    number = wp.min(
        wp.min(room_of(unused, wanted[0], accepted_distance[0]), most[0]), lacking_of(totals, count, wanted[0])
    )
    if number == 0 or index >= number:
        return
    sp = drawn_sp(totals, count, index, number)
    if sp >= 0:
        pixels[cluster] = sps[sp]
        serving[cluster] = 1
        spacing = gbuffer.spacing[sps[sp]] * wp.sqrt(float(count)) * spacing_scale[0]
        set_representative(gbuffer, sps[sp], spacing, cluster, representatives)


@wp.kernel
def adapt_kernel(first: int, sp_count: wp.array[int], totals: wp.array[int], wanted: wp.array[int],
                 unused: wp.array[int], accepted_distance: wp.array[float], most: wp.array[int],
                 extent: wp.array[int]) -> None:  # fmt: skip
    """One thread in all: changes the distance `accepted_distance` (1,) where too few or too many clusters are left
    for others.

    That is what is free less what is lacking, from arrays of fill_kernel. Where no more than `most` (1,) are lacking,
    that becomes all clusters. extent (1,): becomes so much that all in use are below, as the first free ones are taken
    first.
    """
    count = sp_count[0]
    clusters = wanted[0]
    room = room_of(unused, clusters, accepted_distance[0])
    places = unused.shape[0]
    extent[0] = wp.max(extent[0], places - unused[places - 1] + room)
    if count == 0:
        return
    lacking = lacking_of(totals, count, clusters)
    if lacking <= most[0]:
        most[0] = clusters
    left = float(room - lacking) / float(clusters)
    if left < LEAST_FREE or left > MOST_FREE:
        # A surface takes as many as it has squares of that side.
        change = wp.clamp(0.5 * (FREE - left), -MOST_CHANGE, MOST_CHANGE)
        accepted_distance[0] = wp.clamp(
            accepted_distance[0] * (1.0 + change), MIN_ACCEPTED_DISTANCE, MAX_ACCEPTED_DISTANCE
        )

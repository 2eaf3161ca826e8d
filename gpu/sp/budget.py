"""Of so many SP clusters as a frame is to have, which a walk keeps and how many are new (gpu.adaptive tells how many).

A walk keeps clusters from frame to frame. What decides how many places of a view lack one is the distance of an SP from
its nearest representative that is accepted. A walk adapts it until a small share of the clusters stays free: else flat
surfaces take up all, and none are left for what comes into view. With 0.8 at most, so it was in a Cornell box that a
camera turned back to, whose block then had the light of its other side, and 10 to 20 times the errors of a frame from
nothing.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.parameters import parameters
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList

# The deficit of an SP that lacks its whole share of a cluster.
WHOLE_DEFICIT = wp.constant(16)


@wp.struct
@dataclass
class SpClusterParameters:
    """What decides the quality of SP clusters. Distances are in spacings of clusters unless said otherwise.

    samples_per_cluster: SPs that k-means looks at; extra_share: of the clusters, kept for SPs that it serves badly.
    exact_match: nearer SPs have the weight of one at this distance, for w = 1/d has a pole (2022 paper, Eq. 10);
    sparse_search: of all clusters, about so many are looked at where none is near.
    crowded: in accepted distances, nearer than this, two representatives are one too many; as new ones come to SPs that
    are an accepted distance from all, a view that rests comes to rest. same_place: in spacings of pixels, nearer than
    this, a representative is seen where its pixel's SP is, whatever its normal.
    accepted_distance: to begin with, then between min_accepted and max_accepted; min_free, max_free: shares of the
    clusters that are free, between which nothing changes; free: the share that is aimed at; max_change: of the accepted
    distance in a frame; max_new: share of the clusters that may be new in a frame where their number has changed, until
    nothing is lacking, since new ones trace rays, and frames are to take alike.
    """

    samples_per_cluster: int = 4
    extra_share: float = 0.25
    exact_match: float = 1.0e-3
    sparse_search: int = 256
    crowded: float = 0.93
    same_place: float = 1.5
    accepted_distance: float = 0.65
    min_accepted: float = 0.4
    max_accepted: float = 1.2
    min_free: float = 0.01
    free: float = 0.02
    max_free: float = 0.04
    max_change: float = 0.03
    max_new: float = 0.0625


SP_CLUSTER_PARAMETERS: SpClusterParameters = parameters(SpClusterParameters)


@wp.struct
class ClusterBudget:
    """How many clusters a viewer's frame has, (1,) each.

    wanted: clusters; base: those of them that k-means makes; max_new: those that may be new; extent: the first so many
    may be in use; spacing_scale: from a pixel's spacing and the square root of the SPs' number to that of clusters;
    accepted_distance: of an SP from its nearest representative [spacings].
    """

    wanted: wp.array[int]
    base: wp.array[int]
    max_new: wp.array[int]
    extent: wp.array[int]
    spacing_scale: wp.array[float]
    accepted_distance: wp.array[float]


@wp.func
def cluster_spacing(gbuffer: GBuffer, pixel: int, points: PointList, budget: ClusterBudget) -> float:
    """The distance that clusters are to have from each other at a pixel, in unit space."""
    return gbuffer.spacing[pixel] * wp.sqrt(float(points.count[0])) * budget.spacing_scale[0]


@wp.func
def staying_of(used: int, budget: ClusterBudget, chosen: SpClusterParameters) -> int:
    """How many of `used` clusters stay: where there are too many, somewhat fewer than wanted, so that new ones fit.

    Else what comes into view in that frame has the light of other surfaces. So it is, too, where a few clusters have
    much to cover, and the accepted distance can grow no more.
    """
    wanted = budget.wanted[0]
    if used > wanted or budget.accepted_distance[0] >= chosen.max_accepted:
        return wp.min(used, wanted - int(chosen.max_new * float(wanted)))
    return used


@wp.func
def room_of(unused_prefix: wp.array[int], budget: ClusterBudget, chosen: SpClusterParameters) -> int:
    """How many clusters may be new; unused_prefix (cluster,): as in ClusterWork."""
    places = unused_prefix.shape[0]
    unused = unused_prefix[places - 1]
    return wp.min(budget.wanted[0] - staying_of(places - unused, budget, chosen), unused)


@wp.func
def lacking_of(deficit_sums: wp.array[int], points: PointList, budget: ClusterBudget) -> int:
    """How many more clusters SPs need, of which each lacks a share of all; deficit_sums (sp,): running sum."""
    count = points.count[0]
    total = wp.int64(deficit_sums[count - 1])
    return int(total * wp.int64(budget.wanted[0]) / (wp.int64(count) * wp.int64(WHOLE_DEFICIT)))


@wp.kernel
def adapt_budget_kernel(first: int, points: PointList, deficit_sums: wp.array[int], unused_prefix: wp.array[int],
                        chosen: SpClusterParameters, budget: ClusterBudget) -> None:  # fmt: skip
    """One thread in all: changes the accepted distance where too few or too many clusters are left for others.

    That is what is free less what is lacking. Once no more are lacking than may be new, all may be. The extent becomes
    so much that all in use are below it, as the first free ones are taken first.
    """
    room = room_of(unused_prefix, budget, chosen)
    places = unused_prefix.shape[0]
    budget.extent[0] = wp.max(budget.extent[0], places - unused_prefix[places - 1] + room)
    if points.count[0] == 0:
        return
    lacking = lacking_of(deficit_sums, points, budget)
    wanted = budget.wanted[0]
    if lacking <= budget.max_new[0]:
        budget.max_new[0] = wanted
    left = float(room - lacking) / float(wanted)
    if left < chosen.min_free or left > chosen.max_free:
        # A surface takes as many as it has squares of that side, so half of a change of their number is one of it.
        change = wp.clamp(0.5 * (chosen.free - left), -chosen.max_change, chosen.max_change)
        accepted = budget.accepted_distance[0] * (1.0 + change)
        budget.accepted_distance[0] = wp.clamp(accepted, chosen.min_accepted, chosen.max_accepted)

"""SP clusters as the stages after them read them, and what a viewer keeps of them for its next frame."""

import warp as wp

from gpu.clustering.grid import ClusteringParameters, Grid
from gpu.core.device import allocate
from gpu.sp.budget import SP_CLUSTER_PARAMETERS, ClusterBudget

# The deficit of an SP that has no cluster near, and of one that has none at all, since none is in use.
UNSERVED_DEFICIT = wp.constant(1023)
UNASSIGNED_DEFICIT = wp.constant(2047)


@wp.struct
class SpClusters:
    """Clusters' representatives as rays need them, and each SP's clusters.

    position, geometric_normal (cluster,): where rays start; normal (cluster,): for shading; spacing (cluster,): the
    distance to neighbours; used (cluster,): 0 for a cluster without members; serving (cluster,): 1 for the nearest one
    of some SP; order (cluster,): the `fresh` (1,) ones whose representatives are new in this frame, so that neighbours
    in space follow each other, for rays that stay together; alike: what counts as near and alike.
    cluster, weight (F, sp): each SP's nearest clusters and their shares, which add up to 1; deficit (sp,): how badly
    they serve it, 0: well (gpu.sp.fuzzy_assignment).
    """

    position: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    spacing: wp.array[float]
    used: wp.array[int]
    serving: wp.array[int]
    order: wp.array[int]
    fresh: wp.array[int]
    alike: ClusteringParameters
    cluster: wp.array2d[int]
    weight: wp.array2d[float]
    deficit: wp.array[int]


def extra_of(count: int) -> int:
    """How many of `count` clusters are kept for SPs that k-means serves badly."""
    return int(count * SP_CLUSTER_PARAMETERS.extra_share) if count > 1 else 0


class KeptClusters:
    """What a viewer's frame leaves to its next one: the representatives in `grid`, and the `budget` of a walk.

    geometric_normal, serving (cluster,): of the representatives, as in SpClusters. There is room for all of `grid`,
    `count` of which there are to be: all, until `use` says otherwise.
    """

    def __init__(self, grid: Grid, stride: int) -> None:
        """stride: of the pixels that have SPs."""
        self.grid, self._stride = grid, stride
        self.geometric_normal = wp.zeros(grid.capacity, dtype=wp.vec3, device=grid.device)
        self.serving = wp.zeros(grid.capacity, dtype=int, device=grid.device)
        self.budget: ClusterBudget = allocate(ClusterBudget, 1, grid.device)
        self.use(grid.capacity)

    def use(self, count: int, *, at_once: bool = False) -> None:
        """Have so many clusters from the next frame on, but no more than there is room for.

        A walk goes on: evenly many of all stay where there are too many, and new ones come in turn, or `at_once`.
        """
        self.count = min(count, self.grid.capacity)
        base = self.count - extra_of(self.count)
        self.budget.wanted.fill_(self.count)
        self.budget.base.fill_(base)
        self.budget.max_new.fill_(self.count if at_once else 1 + int(SP_CLUSTER_PARAMETERS.max_new * self.count))
        self.budget.spacing_scale.fill_(self._stride * base**-0.5)

    def spread(self, stride: int) -> None:
        """Have SPs `stride` pixels apart from the next frame on."""
        if stride != self._stride:
            self._stride = stride
            self.use(self.count)

    def forget(self) -> None:
        """Begin a walk anew."""
        self.grid.data.spacing.zero_()
        self.serving.zero_()
        self.budget.accepted_distance.fill_(SP_CLUSTER_PARAMETERS.accepted_distance)
        wp.copy(self.budget.max_new, self.budget.wanted)
        wp.copy(self.budget.extent, self.budget.wanted)

    def share(self, clusters: SpClusters) -> None:
        """Have the representatives of `clusters` be these."""
        data = self.grid.data
        clusters.position, clusters.normal, clusters.spacing = data.position, data.normal, data.spacing
        clusters.geometric_normal, clusters.serving = self.geometric_normal, self.serving
        clusters.alike = data.chosen


@wp.struct
class ClusterWork:
    """What a frame only works with, (cluster,) each.

    spacing: in this view, of a representative that may be kept, else 0; crowded: 1 for one that is too near another;
    pixels: of new representatives, −1 for kept ones; unused: 1 where there is no representative, before too many are
    dropped; unused_prefix: the running sum of that.
    """

    spacing: wp.array[float]
    crowded: wp.array[int]
    pixels: wp.array[int]
    unused: wp.array[int]
    unused_prefix: wp.array[int]

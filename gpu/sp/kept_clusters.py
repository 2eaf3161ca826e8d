"""What a walk's SP clusters leave to its next frame, apart for each viewer."""

import warp as wp

from gpu.clustering.grid import Grid
from gpu.sp.seeding import ACCEPTED_DISTANCE, MOST_NEW

# Share of the clusters that is kept for SPs that k-means serves badly.
EXTRA_SHARE = 0.25


def extra_of(count: int) -> int:
    """How many of `count` clusters are kept for SPs that k-means serves badly."""
    return int(count * EXTRA_SHARE) if count > 1 else 0


class KeptClusters:
    """The representatives of a viewer's last frame, in `grid`, and how many a frame is to have.

    There is room for all of `grid`, `count` of which there are to be: all, until `use` says otherwise.
    geometric_normal (cluster,): of the representatives; serving (cluster,): 1 for the nearest of some SP.
    What kernels know of `count`, (1,) each: wanted: that; base: how many of these are of k-means; max_new: how many may
    be new in a frame; extent: of the clusters, the first so many may be in use; spacing_scale: from a pixel's spacing
    and the square root of the SPs' count to that of clusters; accepted_distance: of an SP from its nearest
    representative, that is good enough [spacings].
    """

    def __init__(self, grid: Grid, stride: int) -> None:
        """stride: of the pixels that have SPs."""
        device = grid.device
        self.grid, self.most, self._stride = grid, grid.capacity, stride
        self.geometric_normal = wp.zeros(self.most, dtype=wp.vec3, device=device)
        self.serving = wp.zeros(self.most, dtype=int, device=device)
        self.wanted, self.base, self.max_new, self.extent = (wp.zeros(1, dtype=int, device=device) for _ in range(4))
        self.spacing_scale = wp.zeros(1, dtype=float, device=device)
        self.accepted_distance = wp.full(1, ACCEPTED_DISTANCE, dtype=float, device=device)
        self.use(self.most)

    def use(self, count: int, *, at_once: bool = False) -> None:
        """Have so many clusters from the next frame on, but no more than there is room for.

        A walk goes on: evenly many of all stay where there are too many, and new ones come in turn, or `at_once`.
        """
        self.count = min(count, self.most)
        base = self.count - extra_of(self.count)
        self.wanted.fill_(self.count)
        self.base.fill_(base)
        self.max_new.fill_(self.count if at_once else 1 + int(MOST_NEW * self.count))
        self.spacing_scale.fill_(self._stride * base**-0.5)

    def forget(self) -> None:
        """Begin a walk anew."""
        self.grid.data.spacing.zero_()
        self.serving.zero_()
        self.accepted_distance.fill_(ACCEPTED_DISTANCE)
        wp.copy(self.max_new, self.wanted)
        wp.copy(self.extent, self.wanted)

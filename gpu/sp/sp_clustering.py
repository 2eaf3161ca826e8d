"""Clustering of a frame's shading points: step 4 of the 2022 paper, with Algorithms 1 and 2.

K-means of a sample makes clusters; a share of them is kept back for SPs that these serve badly. A walk keeps the
clusters that stay good and adds those that its view lacks.
"""

from copy import copy

import warp as wp

from gpu.clustering.grid import Grid
from gpu.clustering.kmeans import KMeans
from gpu.core.bucket_sort import Buckets
from gpu.core.device import allocate, duplicate, launch
from gpu.core.morton import CELL_BITS, CELL_COUNT, EMPTY_KEY, morton_key
from gpu.core.radix_sort import running_total
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.sp.budget import SP_CLUSTER_PARAMETERS, WHOLE_DEFICIT, ClusterBudget, adapt_budget_kernel
from gpu.sp.fuzzy_assignment import DEFICIT_IN_FRAME, DEFICIT_TO_FILL, DeficitParameters, fuzzy_assignment_kernel
from gpu.sp.reuse import keep_representatives
from gpu.sp.samples import SampledPoints
from gpu.sp.seeding import fill_unused_kernel, seed_extra_kernel
from gpu.sp.sp_clusters import ClusterWork, KeptClusters, SpClusters, extra_of


class SpClustering:
    """A viewer's SP clusters: `clusters` (SpClusters), and how badly they serve each SP, `deficit` (sp,).

    There is room for `most` clusters; those of a frame, and as many as `use` said, are kept for its next one. The other
    arrays are of the image's size and serve all viewers, whose frames come one after the other.
    """

    def __init__(self, sps: ShadingPoints, most: int, fuzziness: int, *, by_distance: bool) -> None:
        """by_distance: an SP's `fuzziness` clusters have weights 1/distance (Eq. 10), else equal ones (Eq. 8)."""
        device = self.device = sps.device
        self._sps, self.most = sps, min(most, sps.capacity)
        self._assignment_kernel = fuzzy_assignment_kernel(fuzziness, by_distance)
        extra = self._extra = extra_of(self.most)
        per_cluster = SP_CLUSTER_PARAMETERS.samples_per_cluster
        self._samples = SampledPoints(self.most - extra, per_cluster, sps.capacity, device)
        self._kmeans = KMeans(self._samples.capacity, self.most - extra, device, extra=extra)
        self._work: ClusterWork = allocate(ClusterWork, self.most, device)
        self._deficit_sums = wp.zeros(sps.capacity, dtype=int, device=device)
        self._order = Buckets(self.most, CELL_COUNT, device, shift=CELL_BITS)
        self.clusters = SpClusters()
        self.clusters.used = wp.zeros(self.most, dtype=int, device=device)
        self.clusters.order, self.clusters.fresh = self._order.items, self._order.starts[CELL_COUNT:]
        self.clusters.cluster = wp.zeros((fuzziness, sps.capacity), dtype=int, device=device)
        self.clusters.weight = wp.zeros((fuzziness, sps.capacity), dtype=float, device=device)
        self.clusters.deficit = self.deficit = wp.zeros(sps.capacity, dtype=int, device=device)
        self._keep_in(self._kmeans.grid)

    def for_another_viewer(self) -> "SpClustering":
        """One with clusters of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other.clusters = duplicate(SpClusters, self.clusters)
        other._keep_in(self._kmeans.grid.with_own_data())
        return other

    def _keep_in(self, grid: Grid) -> None:
        self._kept = KeptClusters(grid, self._sps.stride)
        self._kept.share(self.clusters)
        self._kmeans = self._kmeans.over(grid, self._kept.budget.base)

    @property
    def count(self) -> int:
        """How many clusters there are to be."""
        return self._kept.count

    def use(self, count: int, *, at_once: bool = False) -> None:
        """Have so many clusters from the next frame on: KeptClusters.use."""
        self._kept.use(count, at_once=at_once)

    def spread(self, stride: int) -> None:
        """Have SPs `stride` pixels apart from the next frame on."""
        self._kept.spread(stride)

    def run(self, gbuffer: GBuffer, seed: int) -> None:
        """K-means of a sample of the SPs (Algorithm 1), then the F nearest clusters of every SP (Algorithm 2)."""
        points, budget = self._sps.points, self._kept.budget
        self._kept.forget()
        self._samples.draw(points, gbuffer, budget, seed)
        # It starts with points spread evenly over the picture: more rounds make none better.
        self._kmeans.run(self._samples.points, iterations=1, seed=seed)
        self._assign(gbuffer, DEFICIT_IN_FRAME)
        running_total(self.deficit, self._deficit_sums)
        inputs = [gbuffer, points, self._deficit_sums, budget, self._work, self.clusters]
        launch(seed_extra_kernel, self._extra, inputs, self.device)
        self._assign(gbuffer, DEFICIT_IN_FRAME, least_deficit=1)
        inputs = [budget, self._kmeans.medoids, self._samples.pixels, self.clusters, self._work.pixels]
        launch(medoid_pixel_kernel, self.most - self._extra, inputs, self.device)
        self._list_new(gbuffer)

    def go_on(self, gbuffer: GBuffer, camera: wp.array, size: tuple[int, int], *, relit: bool = False) -> None:
        """Keep the clusters of the frame before as far as they are good in this view, and add those that it lacks.

        camera: (1,) CameraData that `gbuffer`, an image of `size`, is seen by; relit: all are listed as new, since
        their light is.
        """
        points, budget, work = self._sps.points, self._kept.budget, self._work
        keep_representatives(self._kept, self.clusters, camera, size, gbuffer, points, work)
        self._assign(gbuffer, DEFICIT_TO_FILL)
        running_total(self.deficit, self._deficit_sums)
        inputs = [gbuffer, points, self._deficit_sums, budget, SP_CLUSTER_PARAMETERS, work, self.clusters]
        launch(fill_unused_kernel, self.most, inputs, self.device)
        inputs = [points, self._deficit_sums, work.unused_prefix, SP_CLUSTER_PARAMETERS, budget]
        launch(adapt_budget_kernel, 1, inputs, self.device)
        self._assign(gbuffer, DEFICIT_IN_FRAME, least_deficit=int(WHOLE_DEFICIT))
        self._list_new(gbuffer, relit=relit)

    def _assign(self, gbuffer: GBuffer, scale: DeficitParameters, least_deficit: int = 0) -> None:
        """Find the clusters of all SPs, or of those that have such a deficit by the clusters before."""
        kept, points, chosen = self._kept, self._sps.points, SP_CLUSTER_PARAMETERS
        kept.grid.build()
        inputs = [gbuffer, points, kept.grid.data, kept.budget, chosen, scale, least_deficit, self.clusters]
        launch(self._assignment_kernel, self._sps.capacity, inputs, self.device)

    def _list_new(self, gbuffer: GBuffer, *, relit: bool = False) -> None:
        inputs = [self._work.pixels, self._order.keys, self.clusters]
        launch(representative_kernel, self.most, [gbuffer, *inputs], self.device)
        if relit:
            launch(relist_kernel, self.most, inputs, self.device)
        self._order.sort()


@wp.kernel
def medoid_pixel_kernel(first: int, budget: ClusterBudget, medoids: wp.array[int], sampled: wp.array[int],
                        clusters: SpClusters, pixels: wp.array[int]) -> None:  # fmt: skip
    """One thread a cluster of k-means: its pixel, of `pixels` (cluster,).

    medoids (cluster,): which of the `sampled` (sample,) pixels represent them.
    """
    cluster = first + wp.tid()
    if cluster < budget.base[0] and clusters.spacing[cluster] > 0.0:
        pixels[cluster] = sampled[medoids[cluster]]


@wp.kernel
def representative_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], keys: wp.array[int],
                          clusters: SpClusters) -> None:  # fmt: skip
    """One thread a cluster: what else rays need of the SP that represents it, and its place on the Morton curve.

    pixels (cluster,): where that is, −1 for one that is kept; keys (cluster,): EMPTY_KEY for those that are not new.
    """
    cluster = first + wp.tid()
    keys[cluster] = EMPTY_KEY
    clusters.used[cluster] = wp.where(clusters.spacing[cluster] > 0.0, 1, 0)
    if clusters.used[cluster] == 0:
        return
    pixel = pixels[cluster]
    if pixel < 0:
        return
    clusters.geometric_normal[cluster] = gbuffer.geometric_normal[pixel]
    keys[cluster] = morton_key(gbuffer.position[pixel], gbuffer.geometric_normal[pixel])


@wp.kernel
def relist_kernel(first: int, pixels: wp.array[int], keys: wp.array[int], clusters: SpClusters) -> None:
    """One thread a cluster: lists one that is kept, whose `pixels` (cluster,) is −1, as if it were new."""
    cluster = first + wp.tid()
    if clusters.used[cluster] == 1 and pixels[cluster] < 0:
        keys[cluster] = morton_key(clusters.position[cluster], clusters.geometric_normal[cluster])

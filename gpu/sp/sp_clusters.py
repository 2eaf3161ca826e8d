"""Fuzzy clusters of shading points: each SP belongs to its F nearest ones. Step 4 and Algorithm 2 of the 2022 paper.

Where no representative is near and of like orientation (thin, curved or small parts), the search widens, then relaxes
the normal. SPs that are served badly or not at all get representatives of their own: a share of the clusters is kept
back for them, spread in proportion to need. What is then still unserved takes the nearest cluster of all.
"""

from copy import copy
from functools import cache

import warp as wp

from gpu.clustering.grid import NORMAL_THRESHOLD, Grid, Representatives, level_of
from gpu.clustering.kmeans import KMeans
from gpu.clustering.nearest import RELAXED_THRESHOLD, nearest_of_all, nearest_search
from gpu.core.bucket_sort import Buckets
from gpu.core.device import duplicate, launch
from gpu.core.morton import CELL_BITS, CELL_COUNT, EMPTY_KEY, morton_key
from gpu.core.radix_sort import running_total
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.sp.kept_clusters import KeptClusters, extra_of
from gpu.sp.reuse import drop, keep
from gpu.sp.samples import SampledPoints
from gpu.sp.seeding import (
    DEFICIT_IN_FRAME,
    DEFICIT_TO_FILL,
    WHOLE_DEFICIT,
    DeficitScale,
    adapt_kernel,
    deficit_of,
    extra_kernel,
    fill_kernel,
)

# Of k-means, which starts with points spread evenly over the picture: more make no picture better.
ITERATIONS = 1
# No cluster is in use at all.
UNASSIGNED_DEFICIT = wp.constant(2047)
# Of all clusters, about so many where none is near.
LOOKED_AT = wp.constant(256)
# Of a thread, which waits for memory most of the time: so that many wait at once.
REGISTERS = 112
# Distances below this share of a spacing count as a match: w = 1/d has a pole at the representative (2022, Eq. 10).
MATCH = wp.constant(1.0e-3)


@wp.struct
class SpClusters:
    """Clusters' representatives as rays need them, and each SP's clusters.

    position, geometric (cluster,): where rays start; normal (cluster,): for shading; spacing (cluster,): distance to
    neighbours; used (cluster,): 0 for a cluster without members; order (cluster,): the `fresh` (1,) ones whose
    representatives are new in this frame, so that neighbours in space follow each other, for rays that stay together.
    cluster, weight (F, sp): each SP's nearest clusters and their shares, which add up to 1.
    """

    position: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    spacing: wp.array[float]
    used: wp.array[int]
    order: wp.array[int]
    fresh: wp.array[int]
    cluster: wp.array2d[int]
    weight: wp.array2d[float]


def allocate_sp_clusters(count: int, fuzziness: int, sps: int, device: wp.Device) -> SpClusters:
    """`count` clusters, to `fuzziness` of which each of `sps` SPs belongs."""
    clusters = SpClusters()
    clusters.position = wp.zeros(count, dtype=wp.vec3, device=device)
    clusters.geometric_normal = wp.zeros(count, dtype=wp.vec3, device=device)
    clusters.normal = wp.zeros(count, dtype=wp.vec3, device=device)
    clusters.spacing = wp.zeros(count, dtype=float, device=device)
    clusters.used = wp.zeros(count, dtype=int, device=device)
    clusters.order = wp.zeros(count, dtype=int, device=device)
    clusters.fresh = wp.zeros(1, dtype=int, device=device)
    clusters.cluster = wp.zeros((fuzziness, sps), dtype=int, device=device)
    clusters.weight = wp.zeros((fuzziness, sps), dtype=float, device=device)
    return clusters


@wp.kernel
def representative_kernel(first: int, gbuffer: GBuffer, representatives: Representatives, pixels: wp.array[int],
                          base: wp.array[int], medoids: wp.array[int], sampled: wp.array[int], keys: wp.array[int],
                          out: SpClusters) -> None:  # fmt: skip
    """One thread a cluster: the SP that represents it. Those below `base` (1,) are medoids; others know their pixel.

    pixels (cluster,): −1 for a representative that is kept, which stays where it is; keys (cluster,): the place on the
    curve that `order` follows, EMPTY_KEY for those that are not new.
    """
    cluster = first + wp.tid()
    out.used[cluster] = wp.where(representatives.spacing[cluster] > 0.0, 1, 0)
    keys[cluster] = EMPTY_KEY
    if representatives.spacing[cluster] <= 0.0:
        return
    if cluster < base[0]:
        pixels[cluster] = sampled[medoids[cluster]]
    pixel = pixels[cluster]
    if pixel < 0:
        return
    out.geometric_normal[cluster] = gbuffer.geometric_normal[pixel]
    keys[cluster] = morton_key(gbuffer.position[pixel], gbuffer.geometric_normal[pixel])


@cache
def fuzzy_assign_kernel(fuzziness: int, by_distance: bool) -> wp.Kernel:
    """The kernel of Algorithm 2 for F = `fuzziness`; its weights are 1/distance (Eq. 10) or equal (Eq. 8)."""
    search = nearest_search(fuzziness, widens=True)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def kernel(
        first: int,
        gbuffer: GBuffer,
        sps: wp.array[int],
        sp_count: wp.array[int],
        clusters: Representatives,
        extent: wp.array[int],
        spacing_scale: wp.array[float],
        least_deficit: int,
        scale: DeficitScale,
        accepted_distance: wp.array[float],
        deficit: wp.array[int],
        serving: wp.array[int],
        out: SpClusters,
    ) -> None:
        """One thread an SP: its F nearest clusters, their weights, and how badly it is served (need, 0: well).

        extent (1,): of the clusters, the first so many may be in use; spacing_scale (1,): as in gpu.sp.reuse.
        least_deficit: SPs with less keep what they have; 0: none does, and those far from all clusters get none yet.
        good (1,): the distance that is good enough [spacings]; serving (cluster,): becomes 1 for the nearest one,
        whoever writes it.
        """
        sp = first + wp.tid()
        if sp >= sp_count[0]:
            deficit[sp] = 0
            return
        if deficit[sp] < least_deficit:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        spacing = gbuffer.spacing[pixel] * wp.sqrt(float(sp_count[0])) * spacing_scale[0]
        nearest = search(clusters, position, normal, level_of(spacing), NORMAL_THRESHOLD)
        deficit[sp] = scale.unserved
        if nearest.cluster[0] < 0 and least_deficit > 0:
            # Few SPs come here; any cluster is better than none, and they are the first to be refined. One that looked
            # at all clusters would keep the others waiting.
            count = extent[0]
            every = 1 + count // LOOKED_AT
            nearest.cluster[0] = nearest_of_all(clusters, count, position, normal, RELAXED_THRESHOLD, every)
            if nearest.cluster[0] < 0:
                nearest.cluster[0] = nearest_of_all(clusters, count, position, normal, RELAXED_THRESHOLD, 1)
            nearest.distance[0] = spacing
            if nearest.cluster[0] < 0:
                deficit[sp] = UNASSIGNED_DEFICIT
        elif nearest.cluster[0] >= 0:
            deficit[sp] = deficit_of(scale, accepted_distance[0], nearest.distance[0] / spacing, nearest.alike)
        if nearest.cluster[0] >= 0:
            serving[nearest.cluster[0]] = 1
        total = float(0.0)
        for f in range(wp.static(fuzziness)):
            weight = float(0.0)
            if nearest.cluster[f] >= 0:
                weight = 1.0
                if wp.static(by_distance):
                    weight = spacing / wp.max(nearest.distance[f], MATCH * spacing)
            nearest.distance[f] = weight
            total += weight
        for f in range(wp.static(fuzziness)):
            out.cluster[f, sp] = wp.max(nearest.cluster[f], 0)
            out.weight[f, sp] = nearest.distance[f] / wp.max(total, 1.0e-20)

    return kernel


class SpClustering:
    """A viewer's SP clusters: `clusters` (SpClusters), and how badly they serve each SP, `deficit` (sp,).

    There is room for `most` clusters; those of a frame, and as many as `use` said, are kept for its next one. The other
    arrays are of the image's size and serve all viewers, whose frames come one after the other.
    """

    def __init__(self, sps: ShadingPoints, most: int, fuzziness: int, *, by_distance: bool) -> None:
        device = self.device = sps.device
        self._sps, self.most = sps, min(most, sps.capacity)
        self._kernel = fuzzy_assign_kernel(fuzziness, by_distance)
        self.deficit = wp.zeros(sps.capacity, dtype=int, device=device)
        self._deficits = wp.zeros(sps.capacity, dtype=int, device=device)
        extra = extra_of(self.most)
        base = self.most - extra
        self._samples = SampledPoints(base, sps.capacity, device)
        self._kmeans = KMeans(self._samples.capacity, base, device, extra=extra)
        self._pixels = wp.zeros(self.most, dtype=int, device=device)
        self._spacings = wp.zeros(self.most, dtype=float, device=device)
        self._crowded = wp.zeros(self.most, dtype=int, device=device)
        self._unused = wp.zeros(self.most, dtype=int, device=device)
        self._unused_prefix = wp.zeros(self.most, dtype=int, device=device)
        self._one, self._none = wp.ones(1, dtype=float, device=device), wp.zeros(1, dtype=int, device=device)
        self._order = Buckets(self.most, CELL_COUNT, device, shift=CELL_BITS)
        self.clusters = SpClusters()
        self.clusters.used = wp.zeros(self.most, dtype=int, device=device)
        self.clusters.order, self.clusters.fresh = self._order.items, self._order.starts[CELL_COUNT:]
        self.clusters.cluster = wp.zeros((fuzziness, sps.capacity), dtype=int, device=device)
        self.clusters.weight = wp.zeros((fuzziness, sps.capacity), dtype=float, device=device)
        self._keep_in(self._kmeans.grid)

    def for_another_viewer(self) -> "SpClustering":
        """One with clusters of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other.clusters = duplicate(SpClusters, self.clusters)
        other._keep_in(self._kmeans.grid.with_own_data())
        return other

    def _keep_in(self, grid: Grid) -> None:
        kept = self._kept = KeptClusters(grid, self._sps.stride)
        self._kmeans = self._kmeans.over(grid, kept.base)
        self.clusters.position, self.clusters.normal = grid.data.position, grid.data.normal
        self.clusters.spacing, self.clusters.geometric_normal = grid.data.spacing, kept.geometric_normal

    @property
    def count(self) -> int:
        """How many clusters there are to be."""
        return self._kept.count

    def use(self, count: int, *, at_once: bool = False) -> None:
        """Have so many clusters from the next frame on, but no more than there is room for.

        A walk goes on: evenly many of all stay where there are too many, and new ones come in turn, or `at_once`.
        """
        self._kept.use(count, at_once=at_once)

    def run(self, gbuffer: GBuffer, seed: int) -> None:
        """K-means of a sample of the SPs, then the F nearest clusters of every SP."""
        sps, kept = self._sps, self._kept
        kept.forget()
        self._samples.draw(sps, gbuffer, kept.base, kept.spacing_scale, seed)
        self._kmeans.run(self._samples.points, ITERATIONS, seed)
        kept.grid.build()
        self._assign(gbuffer, DEFICIT_IN_FRAME, self._one, least_deficit=0)
        running_total(self.deficit, self._deficits)
        inputs = [gbuffer, sps.pixels, sps.count, self._deficits, kept.spacing_scale, kept.base, kept.wanted]
        launch(extra_kernel, extra_of(self.most), [*inputs, kept.grid.data, self._pixels], self.device)
        self._finish(gbuffer, kept.base, least_deficit=1)

    def go_on(self, gbuffer: GBuffer, camera: wp.array, size: tuple[int, int]) -> None:
        """Keep the clusters of the frame before as far as they are good in this view, and add those that it lacks.

        camera: (1,) CameraData that `gbuffer`, an image of `size`, is seen by.
        """
        sps, kept, representatives = self._sps, self._kept, self._kept.grid.data
        accepted, work = kept.accepted_distance, (self._spacings, self._crowded, self._pixels)
        keep(camera, size, gbuffer, sps, kept.spacing_scale, accepted, representatives, kept.serving, *work)
        drop(representatives, kept.wanted, accepted, self._unused, self._unused_prefix)
        kept.grid.build()
        self._assign(gbuffer, DEFICIT_TO_FILL, accepted, least_deficit=0)
        running_total(self.deficit, self._deficits)
        counts = kept.wanted, self._unused_prefix, accepted, kept.max_new
        inputs = [gbuffer, sps.pixels, sps.count, self._deficits, kept.spacing_scale, *counts]
        launch(fill_kernel, self.most, [*inputs, representatives, self._pixels, kept.serving], self.device)
        launch(adapt_kernel, 1, [sps.count, self._deficits, *counts, kept.extent], self.device)
        self._finish(gbuffer, self._none, least_deficit=int(WHOLE_DEFICIT))

    def _finish(self, gbuffer: GBuffer, base: wp.array, *, least_deficit: int) -> None:
        """Serve the needy by the new clusters too, of which the first `base` (1,) are medoids, and order all."""
        self._kept.grid.build()
        self._assign(gbuffer, DEFICIT_IN_FRAME, self._one, least_deficit=least_deficit)
        inputs = [gbuffer, self._kept.grid.data, self._pixels, base, self._kmeans.medoids, self._samples.pixels]
        launch(representative_kernel, self.most, [*inputs, self._order.keys, self.clusters], self.device)
        self._order.sort()

    def _assign(self, gbuffer: GBuffer, scale: DeficitScale, accepted: wp.array, *, least_deficit: int) -> None:
        sps, kept = self._sps, self._kept
        inputs = [gbuffer, sps.pixels, sps.count, kept.grid.data, kept.extent, kept.spacing_scale, least_deficit]
        outputs = [scale, accepted, self.deficit, kept.serving, self.clusters]
        launch(self._kernel, sps.capacity, [*inputs, *outputs], self.device)

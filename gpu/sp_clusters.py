"""Fuzzy clusters of shading points: each SP belongs to its F nearest ones. Step 4 and Algorithm 2 of the 2022 paper.

Where no representative is near and of like orientation (thin, curved or small parts), the search widens, then relaxes
the normal. SPs that are served badly or not at all get representatives of their own: a share of the clusters is kept
back for them, spread in proportion to need. What is then still unserved takes the nearest cluster of all.
"""

from copy import copy
from functools import cache

import warp as wp

from gpu.buckets import Buckets
from gpu.carry import Table
from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.grid import NORMAL_THRESHOLD, Representatives, level_of
from gpu.grouping import running_total
from gpu.kept_clusters import keep
from gpu.kmeans import KMeans
from gpu.nearest import RELAXED_THRESHOLD, nearest_of_all, nearest_search
from gpu.new_clusters import (
    FILLING,
    GOOD,
    MOST_NEW,
    SERVICE,
    WHOLE_NEED,
    NeedScale,
    adapt_kernel,
    extra_kernel,
    fill_kernel,
    free_kernel,
    need_of,
)
from gpu.order import CELL_BITS, CELL_COUNT, EMPTY_KEY, order_key
from gpu.settings import Weighting
from gpu.shading_points import SampledPoints, ShadingPoints

# Of k-means, which starts with points spread evenly over the picture: more make no picture better.
ITERATIONS = 1
SAMPLES_PER_CLUSTER = 4
# Share of the clusters that is kept for SPs that k-means serves badly.
EXTRA_SHARE = 0.25
# No cluster is in use at all.
UNASSIGNED_NEED = wp.constant(2047)
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
    geometric: wp.array[wp.vec3]
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
    clusters.geometric = wp.zeros(count, dtype=wp.vec3, device=device)
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
                          base: int, medoids: wp.array[int], sampled: wp.array[int], keys: wp.array[int],
                          out: SpClusters) -> None:  # fmt: skip
    """One thread a cluster: the SP that represents it. Those below `base` are medoids; others know their pixel.

    pixels (cluster,): −1 for a representative that is kept, which stays where it is; keys (cluster,): the place on the
    curve that `order` follows, EMPTY_KEY for those that are not new.
    """
    cluster = first + wp.tid()
    out.used[cluster] = wp.where(representatives.spacing[cluster] > 0.0, 1, 0)
    keys[cluster] = EMPTY_KEY
    if representatives.spacing[cluster] <= 0.0:
        return
    if cluster < base:
        pixels[cluster] = sampled[medoids[cluster]]
    pixel = pixels[cluster]
    out.spacing[cluster] = representatives.spacing[cluster]
    if pixel < 0:
        return
    out.position[cluster] = gbuffer.position[pixel]
    out.geometric[cluster] = gbuffer.geometric[pixel]
    out.normal[cluster] = gbuffer.normal[pixel]
    keys[cluster] = order_key(gbuffer.position[pixel], gbuffer.geometric[pixel])


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
        spacing_scale: float,
        least_need: int,
        scale: NeedScale,
        good: wp.array[float],
        need: wp.array[int],
        serving: wp.array[int],
        out: SpClusters,
    ) -> None:
        """One thread an SP: its F nearest clusters, their weights, and how badly it is served (need, 0: well).

        least_need: SPs with less keep what they have; 0: none does, and those far from all clusters get none yet.
        good (1,): the distance that is good enough [spacings]; serving (cluster,): becomes 1 for the nearest one,
        whoever writes it.
        """
        sp = first + wp.tid()
        if sp >= sp_count[0]:
            need[sp] = 0
            return
        if need[sp] < least_need:
            return
        pixel = sps[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        spacing = gbuffer.spacing[pixel] * wp.sqrt(float(sp_count[0])) * spacing_scale
        nearest = search(clusters, position, normal, level_of(spacing), NORMAL_THRESHOLD)
        need[sp] = scale.unserved
        if nearest.cluster[0] < 0 and least_need > 0:
            # Few SPs come here; any cluster is better than none, and they are the first to be refined. One that looked
            # at all clusters would keep the others waiting.
            every = 1 + clusters.spacing.shape[0] // LOOKED_AT
            nearest.cluster[0] = nearest_of_all(clusters, position, normal, RELAXED_THRESHOLD, every)
            if nearest.cluster[0] < 0:
                nearest.cluster[0] = nearest_of_all(clusters, position, normal, RELAXED_THRESHOLD, 1)
            nearest.distance[0] = spacing
            if nearest.cluster[0] < 0:
                need[sp] = UNASSIGNED_NEED
        elif nearest.cluster[0] >= 0:
            need[sp] = need_of(scale, good[0], nearest.distance[0] / spacing, nearest.alike)
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
    """Clusters a frame's SPs; `clusters` (SpClusters) and `need` (sp,) hold the result, arrays are allocated once."""

    def __init__(
        self, capacity: int, cluster_count: int, fuzziness: int, weighting: Weighting, device: wp.Device
    ) -> None:
        self.device, self._capacity = device, capacity
        self._kernel = fuzzy_assign_kernel(fuzziness, weighting is Weighting.DISTANCE)
        self.need = wp.zeros(capacity, dtype=int, device=device)
        self._needs = wp.zeros(capacity, dtype=int, device=device)
        self.clusters = allocate_sp_clusters(0, fuzziness, capacity, device)
        self._one = wp.ones(1, dtype=float, device=device)
        self._allocate(cluster_count)

    def resized(self, cluster_count: int) -> "SpClustering":
        """Another number of clusters. It shares the arrays of SPs, so these hold the result of whichever ran last."""
        other = copy(self)
        other._allocate(cluster_count)
        return other

    def _allocate(self, cluster_count: int) -> None:
        self.count = min(cluster_count, self._capacity)
        self._extra = int(self.count * EXTRA_SHARE) if self.count > 1 else 0
        self._base = self.count - self._extra
        self._samples = SampledPoints(min(self._capacity, SAMPLES_PER_CLUSTER * self._base), self.device)
        self._kmeans = KMeans(self._samples.capacity, self._base, self.device, extra=self._extra)
        self._pixels = wp.zeros(self.count, dtype=int, device=self.device)
        self._spacings = wp.zeros(self.count, dtype=float, device=self.device)
        self._crowded = wp.zeros(self.count, dtype=int, device=self.device)
        self._serving = wp.zeros(self.count, dtype=int, device=self.device)
        self._free = wp.zeros(self.count, dtype=int, device=self.device)
        self._frees = wp.zeros(self.count, dtype=int, device=self.device)
        self._good = wp.zeros(1, dtype=float, device=self.device)
        self._most_new = wp.full(1, self.count, dtype=int, device=self.device)
        self._order = Buckets(self.count, CELL_COUNT, self.device, shift=CELL_BITS)
        members, fuzziness = self.clusters, self.clusters.cluster.shape[0]
        self.clusters = allocate_sp_clusters(self.count, fuzziness, 0, self.device)
        self.clusters.cluster, self.clusters.weight = members.cluster, members.weight
        self.clusters.order, self.clusters.fresh = self._order.items, self._order.starts[CELL_COUNT:]

    @property
    def tables(self) -> list[Table]:
        """What is known of clusters, which `go_on` keeps."""
        known, clusters = self._kmeans.grid.data, self.clusters
        arrays = known.position, known.normal, known.spacing, clusters.position, clusters.geometric, clusters.normal
        return [Table(values) for values in (*arrays, self._serving, self._good)]

    def run(self, sps: ShadingPoints, gbuffer: GBuffer, seed: int) -> None:
        """K-means of a sample of `sps`, then the F nearest clusters of every SP."""
        grid, scale = self._kmeans.grid, self._spacing_scale(sps)
        grid.data.spacing.zero_()
        self._serving.zero_()
        self._good.fill_(GOOD)
        self._most_new.fill_(self.count)
        self._samples.draw(sps, gbuffer, scale, seed)
        self._kmeans.run(self._samples.points, ITERATIONS, seed)
        grid.build()
        self._assign(sps, gbuffer, SERVICE, self._one, least_need=0)
        running_total(self.need, self._needs)
        inputs = [gbuffer, sps.pixels, sps.count, self._needs, scale, self._base, self._extra]
        launch(extra_kernel, self._extra, [*inputs, grid.data, self._pixels], self.device)
        self._finish(sps, gbuffer, self._base, least_need=1)

    def go_on(
        self, sps: ShadingPoints, gbuffer: GBuffer, camera: wp.array, size: tuple[int, int], *, carried: bool = False
    ) -> None:
        """Keep the clusters of the run before as far as they are good in this view, and add those that it lacks.

        camera: (1,) CameraData that `gbuffer`, an image of `size`, is seen by; carried: whether that run had another
        number of clusters, whose `tables` these have.
        """
        grid, scale = self._kmeans.grid, self._spacing_scale(sps)
        if carried:
            self._most_new.fill_(1 + int(MOST_NEW * self.count))
            grid.build()
        work = self._spacings, self._crowded, self._pixels
        keep(camera, size, gbuffer, sps, scale, self._good, grid.data, self._serving, *work)
        grid.build()
        self._assign(sps, gbuffer, FILLING, self._good, least_need=0)
        running_total(self.need, self._needs)
        launch(free_kernel, self.count, [grid.data, self._free], self.device)
        running_total(self._free, self._frees)
        inputs = [gbuffer, sps.pixels, sps.count, self._needs, scale, self._frees, self._most_new]
        launch(fill_kernel, self.count, [*inputs, grid.data, self._pixels, self._serving], self.device)
        inputs = [sps.count, self._needs, self._frees, self._good, self._most_new]
        launch(adapt_kernel, 1, inputs, self.device)
        self._finish(sps, gbuffer, 0, least_need=int(WHOLE_NEED))

    def _spacing_scale(self, sps: ShadingPoints) -> float:
        return float(sps.stride * self._base**-0.5)

    def _finish(self, sps: ShadingPoints, gbuffer: GBuffer, base: int, *, least_need: int) -> None:
        """Serve the needy by the new clusters too, of which the first `base` are medoids, and order all."""
        self._kmeans.grid.build()
        self._assign(sps, gbuffer, SERVICE, self._one, least_need=least_need)
        inputs = [gbuffer, self._kmeans.grid.data, self._pixels, base, self._kmeans.medoids, self._samples.pixels]
        launch(representative_kernel, self.count, [*inputs, self._order.keys, self.clusters], self.device)
        self._order.sort()

    def _assign(
        self, sps: ShadingPoints, gbuffer: GBuffer, scale: NeedScale, good: wp.array, *, least_need: int
    ) -> None:
        inputs = [gbuffer, sps.pixels, sps.count, self._kmeans.grid.data, self._spacing_scale(sps), least_need]
        launch(self._kernel, sps.capacity, [*inputs, scale, good, self.need, self._serving, self.clusters], self.device)

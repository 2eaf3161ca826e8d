"""The sample of a frame's shading points that is clustered."""

import warp as wp

from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.sampling.sobol import hashed
from gpu.sp.budget import ClusterBudget, cluster_spacing


@wp.kernel
def sample_points_kernel(first: int, gbuffer: GBuffer, points: PointList, budget: ClusterBudget, per_cluster: int,
                         seed: int, sampled: wp.array[int], out: Points) -> None:  # fmt: skip
    """One thread a sample: one SP of each of equal runs of the list, or every SP when they are fewer.

    per_cluster: samples for each cluster of k-means, as far as there is room in `sampled` (sample,), their pixels.
    """
    index = first + wp.tid()
    sp_count = points.count[0]
    count = wp.min(wp.min(per_cluster * budget.base[0], sampled.shape[0]), sp_count)
    if index == 0:
        out.count[0] = count
    if index >= count:
        return
    begin = int(wp.int64(index) * wp.int64(sp_count) / wp.int64(count))
    end = int(wp.int64(index + 1) * wp.int64(sp_count) / wp.int64(count))
    pick = hashed(wp.uint32(index) ^ hashed(wp.uint32(seed)))
    pixel = points.pixels[begin + int(pick % wp.uint32(wp.max(end - begin, 1)))]
    sampled[index] = pixel
    out.position[index] = gbuffer.position[pixel]
    out.normal[index] = gbuffer.normal[pixel]
    out.weight[index] = 1.0
    out.spacing[index] = cluster_spacing(gbuffer, pixel, points, budget)


class SampledPoints:
    """The paper's downsampling by γ (Alg. 1, line 1): `points` holds some SPs, `pixels` their pixels."""

    def __init__(self, clusters: int, per_cluster: int, sps: int, device: wp.Device) -> None:
        """For at most so many clusters of so many SPs, with `per_cluster` samples each."""
        self._per_cluster, self.device = per_cluster, device
        self.capacity = min(sps, per_cluster * clusters)
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.points: Points = allocate(Points, self.capacity, device)
        self.points.count = wp.zeros(1, dtype=int, device=device)

    def draw(self, sps: PointList, gbuffer: GBuffer, budget: ClusterBudget, seed: int) -> None:
        """Sample `sps` evenly, for the clusters of `budget` that k-means makes."""
        inputs = [gbuffer, sps, budget, self._per_cluster, seed, self.pixels, self.points]
        launch(sample_points_kernel, self.capacity, inputs, self.device)

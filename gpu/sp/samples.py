"""The sample of a frame's shading points that is clustered."""

import warp as wp

from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.sampling.sobol import hashed

# More make no picture better.
SAMPLES_PER_CLUSTER = 4


@wp.kernel
def sample_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], total: wp.array[int], base: wp.array[int],
                  scale: wp.array[float], seed: int, sampled: wp.array[int], out: Points) -> None:  # fmt: skip
    """One thread a sample: one SP of each of equal runs of the list, or every SP when they are fewer.

    base (1,): clusters, which have SAMPLES_PER_CLUSTER each as far as there is room in `sampled` (sample,); scale (1,):
    from a pixel's spacing and the square root of the SPs' count to the distance of clusters.
    """
    index = first + wp.tid()
    sp_count = total[0]
    count = wp.min(wp.min(wp.static(SAMPLES_PER_CLUSTER) * base[0], sampled.shape[0]), sp_count)
    if index == 0:
        out.count[0] = count
    if index >= count:
        return
    begin = int(wp.int64(index) * wp.int64(sp_count) / wp.int64(count))
    end = int(wp.int64(index + 1) * wp.int64(sp_count) / wp.int64(count))
    pick = hashed(wp.uint32(index) ^ hashed(wp.uint32(seed)))
    pixel = pixels[begin + int(pick % wp.uint32(wp.max(end - begin, 1)))]
    sampled[index] = pixel
    out.position[index] = gbuffer.position[pixel]
    out.normal[index] = gbuffer.normal[pixel]
    out.weight[index] = 1.0
    out.spacing[index] = gbuffer.spacing[pixel] * wp.sqrt(float(sp_count)) * scale[0]


class SampledPoints:
    """The paper's downsampling by γ (Alg. 1, line 1): `points` holds some SPs, `pixels` their pixels."""

    def __init__(self, clusters: int, sps: int, device: wp.Device) -> None:
        """For at most so many clusters of so many SPs."""
        self.capacity, self.device = min(sps, SAMPLES_PER_CLUSTER * clusters), device
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.points: Points = allocate(Points, self.capacity, device)
        self.points.count = wp.zeros(1, dtype=int, device=device)

    def draw(self, sps: ShadingPoints, gbuffer: GBuffer, base: wp.array, scale: wp.array, seed: int) -> None:
        """Sample `sps` evenly for `base` (1,) clusters.

        scale (1,): distance wanted of these [pixels] over the root of the SPs' count.
        """
        inputs = [gbuffer, sps.pixels, sps.count, base, scale, seed, self.pixels, self.points]
        launch(sample_kernel, self.capacity, inputs, self.device)

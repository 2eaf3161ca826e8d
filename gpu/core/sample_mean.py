"""The mean of a few samples of something large, on the device, in one block: the same bits every time."""

import warp as wp

from gpu.core.device import BLOCK

SAMPLES = wp.constant(1024)


@wp.kernel(module="unique")
def sample_mean_kernel(samples: wp.array[float], mean: wp.array[float]) -> None:
    """One block: the mean of the samples."""
    total = wp.tile_sum(wp.tile_load(samples, shape=SAMPLES))
    wp.tile_store(mean, total * wp.static(1.0 / float(SAMPLES)))


def find_sample_mean(samples: wp.array, mean: wp.array) -> None:
    """Write the mean of `samples` (SAMPLES,) into `mean` (1,)."""
    wp.launch_tiled(sample_mean_kernel, dim=[1], inputs=[samples, mean], device=mean.device, block_dim=BLOCK)

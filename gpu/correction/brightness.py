"""The mean brightness of pictures' indirect light, without waiting for the host."""

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import BLOCK, launch
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints

# SPs whose brightness stands for that of the picture.
SAMPLES = wp.constant(1024)


@wp.kernel
def brightness_sample_kernel(first: int, gbuffer: GBuffer, points: PointList, starts: wp.array[int],
                             irradiance: wp.array[wp.vec3], samples: wp.array[float]) -> None:  # fmt: skip
    """One thread a sample: the brightness of the first SP of each of SAMPLES equal runs of each tile's in the list.

    starts (tile + 1,): of the tiles' SPs.
    """
    sample = first + wp.tid()
    samples[sample] = 0.0
    tile = sample // SAMPLES
    run = sample - tile * SAMPLES
    begin = starts[tile]
    count = starts[tile + 1] - begin
    if count > 0:
        number = int(wp.int64(run) * wp.int64(count) / wp.static(wp.int64(int(SAMPLES))))
        pixel = points.pixels[begin + number]
        samples[sample] = brightness(wp.cw_mul(reflectance(gbuffer, pixel), irradiance[pixel]))


@wp.kernel(module="unique")
def mean_brightness_kernel(samples: wp.array[float], mean: wp.array[float]) -> None:
    """One block a tile: the mean of its samples."""
    tile = wp.tid()
    total = wp.tile_sum(wp.tile_load(samples, shape=SAMPLES, offset=tile * SAMPLES))
    wp.tile_store(mean, total * wp.static(1.0 / float(SAMPLES)), offset=tile)


class MeanBrightness:
    """About how bright each tile is: `value` (tile,) [W/m²/sr], the mean of its `samples` (SAMPLES a tile,)."""

    def __init__(self, device: wp.Device, tiles: int = 1) -> None:
        self.device, self.tiles = device, tiles
        self.samples = wp.zeros(tiles * SAMPLES, dtype=float, device=device)
        self.value = wp.zeros(tiles, dtype=float, device=device)

    def find(self, gbuffer: GBuffer, sps: ShadingPoints, irradiance: wp.array) -> None:
        """Measure it by some of all `sps`; irradiance (pixel,)."""
        inputs = [gbuffer, sps.points, sps.starts, irradiance, self.samples]
        launch(brightness_sample_kernel, len(self.samples), inputs, self.device)
        inputs = [self.samples, self.value]
        wp.launch_tiled(mean_brightness_kernel, dim=[self.tiles], inputs=inputs, device=self.device, block_dim=BLOCK)

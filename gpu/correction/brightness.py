"""The mean brightness of pictures' indirect light, without waiting for the host."""

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.sample_mean import SAMPLES, find_sample_mean
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints


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
        find_sample_mean(self.samples, self.value)

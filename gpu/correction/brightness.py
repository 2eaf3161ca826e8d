"""The mean brightness of a picture's indirect light, without waiting for the host."""

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.sample_mean import SAMPLES, find_sample_mean
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints


@wp.kernel
def brightness_sample_kernel(first: int, gbuffer: GBuffer, points: PointList,
                             irradiance: wp.array[wp.vec3], samples: wp.array[float]) -> None:  # fmt: skip
    """One thread a sample: the brightness of the first SP of each of SAMPLES equal runs of the list.

    irradiance (pixel,) [W/m²]; samples (SAMPLES,) [W/m²/sr], 0 where there is no SP.
    """
    sample = first + wp.tid()
    samples[sample] = 0.0
    if points.count[0] > 0:
        pixel = points.pixels[int(wp.int64(sample) * wp.int64(points.count[0]) / wp.int64(SAMPLES))]
        samples[sample] = brightness(wp.cw_mul(reflectance(gbuffer, pixel), irradiance[pixel]))


class MeanBrightness:
    """About how bright a picture is: `value` (1,) [W/m²/sr], the mean of `samples` (SAMPLES,)."""

    def __init__(self, device: wp.Device) -> None:
        self.device = device
        self.samples = wp.zeros(SAMPLES, dtype=float, device=device)
        self.value = wp.zeros(1, dtype=float, device=device)

    def find(self, gbuffer: GBuffer, sps: ShadingPoints, irradiance: wp.array) -> None:
        """Measure it by some of all `sps`; irradiance (pixel,)."""
        launch(brightness_sample_kernel, SAMPLES, [gbuffer, sps.points, irradiance, self.samples], self.device)
        find_sample_mean(self.samples, self.value)

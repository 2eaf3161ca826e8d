"""Which shading points neighbours must not speak for. Beyond the 2022 paper.

What rays correct is shared between neighbours on a surface. That is wrong at few pixels, but far: in cracks, behind
slats, at contacts, where one percent of the pixels hold nine tenths of the relative error. There an SP's own rays find
it much darker than what it shares. Few rays often do so by chance, too: in a conference room one of 47 such SPs is that
dark. So suspects get as many rays again, and those that remain get many (gpu.correction.outlier_shading).
"""

import math

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.correction.brightness import MeanBrightness
from gpu.correction.top_k import LAST, Selection
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sp.sp_clusters import UNSERVED_DEFICIT

# Of keys; 0 is that of an SP without a cluster.
STEPS_PER_OCTAVE = wp.constant(12.0)
WORST_OCTAVE = wp.constant(12.0)
# Of the mean picture's brightness: darker than that is as good as black to the eye and to relMSE.
DARK = wp.constant(0.1)


@wp.kernel
def outlier_key_kernel(first: int, gbuffer: GBuffer, points: PointList,
                   deficit: wp.array[int], irradiance: wp.array[wp.vec3], own: wp.array[wp.vec3],
                   shared: wp.array[wp.vec3], mean: wp.array[float], keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a listed SP: by how much it may be too bright, relative to how dark it may be, as a key; worst first.

    deficit (sp,): UNSERVED_DEFICIT marks SPs without a cluster, which come before all others; own, shared (pixel,):
    what corrects the `irradiance` (pixel,) by the SP's rays alone, and with its neighbours'.
    """
    place = first + wp.tid()
    keys[place] = LAST
    if place >= points.count[0]:
        return
    if deficit[points.numbers[place]] >= UNSERVED_DEFICIT:
        keys[place] = 0
        return
    pixel = points.pixels[place]
    reflected = reflectance(gbuffer, pixel)
    high = brightness(wp.cw_mul(reflected, irradiance[pixel] + shared[pixel]))
    low = wp.max(brightness(wp.cw_mul(reflected, irradiance[pixel] + own[pixel])), 0.0)
    ratio = (high - low) / (low + DARK * mean[0] + 1.0e-30)
    if ratio > 0.0:
        keys[place] = wp.clamp(int(STEPS_PER_OCTAVE * (WORST_OCTAVE - wp.log2(ratio))), 1, LAST)


class OutlierPoints(Selection):
    """Of up to `among` SPs the at most `capacity` that are most likely far too bright: ListedPoints.

    least: what may be too bright, relative to how dark the SP may be, below which it is left as it is.
    """

    def __init__(self, among: int, capacity: int, least: float, device: wp.Device) -> None:
        end = int(float(STEPS_PER_OCTAVE) * (float(WORST_OCTAVE) - math.log2(least)))
        super().__init__(among, capacity, end, device)

    def find(self, points: ListedPoints, gbuffer: GBuffer, deficit: wp.array, irradiance: wp.array, own: wp.array,
             shared: wp.array, mean: MeanBrightness) -> None:  # fmt: skip
        """List the worst of `points`, as `outlier_key_kernel` tells."""
        inputs = [gbuffer, points.points, deficit, irradiance, own, shared, mean.value, self.keys]
        launch(outlier_key_kernel, points.capacity, inputs, self.device)
        self.choose(points)

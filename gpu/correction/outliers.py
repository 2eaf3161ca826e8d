"""Which shading points neighbours must not speak for. Beyond the 2022 paper.

What rays correct is shared between neighbours on a surface. That is wrong at few pixels, but far: in cracks, behind
slats, at contacts, where one percent of the pixels hold nine tenths of the relative error. There an SP's own rays find
it much darker than what it shares. Few rays often do so by chance, too: in a conference room one of 47 such SPs is that
dark. So suspects get as many rays again, and those that remain get many (gpu.correction.outlier_shading).
"""

import math
from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.correction.brightness import MeanBrightness
from gpu.correction.top_k import LAST, Selection
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sp.sp_clusters import UNSERVED_DEFICIT

# How keys encode ratios; 0 is the key of an SP without a cluster.
STEPS_PER_OCTAVE = wp.constant(12.0)
WORST_OCTAVE = wp.constant(12.0)


@dataclass(frozen=True)
class OutlierParameters:
    """What is far too bright.

    least: what may be too bright by less, relative to how dark the SP may be, is left as it is.
    dark: of the mean picture's brightness; darker than that is as good as black to the eye and to relMSE.
    """

    least: float = 0.25
    dark: float = 0.1


OUTLIER_PARAMETERS = OutlierParameters()


@wp.struct
class Dispute:
    """What tells how far SPs may be too bright.

    deficit (sp,): UNSERVED_DEFICIT marks SPs without a cluster; own, shared (pixel,): what corrects the `irradiance`
    (pixel,) by the SP's rays alone, and with its neighbours'; mean (1,): the picture's brightness, of which the share
    `dark` is as good as black.
    """

    deficit: wp.array[int]
    irradiance: wp.array[wp.vec3]
    own: wp.array[wp.vec3]
    shared: wp.array[wp.vec3]
    mean: wp.array[float]
    dark: float


@wp.kernel
def outlier_key_kernel(first: int, gbuffer: GBuffer, points: PointList, dispute: Dispute,
                       keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a listed SP: by how much it may be too bright, relative to how dark it may be, as a key; worst first.

    keys (place,); SPs without a cluster come before all others.
    """
    place = first + wp.tid()
    keys[place] = LAST
    if place >= points.count[0]:
        return
    if dispute.deficit[points.numbers[place]] >= UNSERVED_DEFICIT:
        keys[place] = 0
        return
    pixel = points.pixels[place]
    reflected = reflectance(gbuffer, pixel)
    high = brightness(wp.cw_mul(reflected, dispute.irradiance[pixel] + dispute.shared[pixel]))
    low = wp.max(brightness(wp.cw_mul(reflected, dispute.irradiance[pixel] + dispute.own[pixel])), 0.0)
    ratio = (high - low) / (low + dispute.dark * dispute.mean[0] + 1.0e-30)
    if ratio > 0.0:
        keys[place] = wp.clamp(int(STEPS_PER_OCTAVE * (WORST_OCTAVE - wp.log2(ratio))), 1, LAST)


class OutlierPoints(Selection):
    """Of up to `among` SPs the at most `capacity` that are most likely far too bright: ListedPoints."""

    def __init__(self, among: int, capacity: int, device: wp.Device,
                 quality: OutlierParameters = OUTLIER_PARAMETERS) -> None:  # fmt: skip
        self._dark = quality.dark
        end = int(float(STEPS_PER_OCTAVE) * (float(WORST_OCTAVE) - math.log2(quality.least)))
        super().__init__(among, capacity, end, device)

    def find(self, points: ListedPoints, gbuffer: GBuffer, deficit: wp.array, irradiance: wp.array, own: wp.array,
             shared: wp.array, mean: MeanBrightness) -> None:  # fmt: skip
        """List the worst of `points`, as `outlier_key_kernel` tells; the arrays: as Dispute has them."""
        dispute = Dispute()
        dispute.deficit, dispute.irradiance, dispute.own, dispute.shared = deficit, irradiance, own, shared
        dispute.mean, dispute.dark = mean.value, self._dark
        launch(outlier_key_kernel, points.capacity, [gbuffer, points.points, dispute, self.keys], self.device)
        self.choose(points)

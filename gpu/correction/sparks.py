"""Sparks: what few rays of points find and count for much. They are spread over the surface around, which has as much
light as before; cut off, they would leave pictures too dark.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.irradiance import Indirect


@wp.struct
@dataclass
class SparkParameters:
    """What all rays of an SP find in frame n of a still view is a spark beyond first_most + n·more_most times what its
    VPLs would send, were none hidden. So no pixel sparkles, and blur of what is spread fades from the mean.
    """

    first_most: float = 2.0
    more_most: float = 0.125


SPARK_PARAMETERS: SparkParameters = parameters(SparkParameters)


@wp.kernel
def take_sparks_kernel(first: int, points: PointList, sample: int, chosen: SparkParameters, indirect: Indirect,
                       sparks: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: moves what is a spark of its irradiance [W/m²] to `sparks` (pixel,)."""
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    light = indirect.irradiance[pixel]
    unoccluded = indirect.unoccluded_near[sp] + indirect.unoccluded_far[sp]
    most = (chosen.first_most + float(sample) * chosen.more_most) * unoccluded
    kept = light * wp.min(most / wp.max(brightness(light), 1.0e-30), 1.0)
    indirect.irradiance[pixel] = kept
    sparks[pixel] = light - kept


def take_sparks(sps: ShadingPoints, sample: int, indirect: Indirect, sparks: wp.array) -> None:
    """Move sparks of frame `sample` of a still view from the irradiance of `sps` to `sparks` (pixel,) [W/m²].

    indirect: as the SPs were shaded, with what their rays found. Pixels without an SP are left alone.
    """
    launch(take_sparks_kernel, sps.capacity, [sps.points, sample, SPARK_PARAMETERS, indirect, sparks], sps.device)

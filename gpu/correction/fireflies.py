"""Fireflies: single bright pixels, of what few rays find and count for much.

What they have too much of is spread over the surface around, which has as much light as before. Cut off, it would leave
pictures too dark.
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
class FireflyParameters:
    """What all rays of an SP find in frame n of a still view is too much beyond first_most + n·more_most times what its
    VPLs would send, were none hidden. So no pixel sparkles, and blur of what is spread fades from the mean.
    """

    first_most: float = 2.0
    more_most: float = 0.125


FIREFLY_PARAMETERS: FireflyParameters = parameters(FireflyParameters)


@wp.kernel
def take_fireflies_kernel(first: int, points: PointList, sample: int, chosen: FireflyParameters, indirect: Indirect,
                          excess: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: moves what its irradiance has too much to `excess` (pixel,) [W/m²]."""
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    light = indirect.irradiance[pixel]
    unoccluded = indirect.unoccluded_near[sp] + indirect.unoccluded_far[sp]
    most = (chosen.first_most + float(sample) * chosen.more_most) * unoccluded
    kept = light * wp.min(most / wp.max(brightness(light), 1.0e-30), 1.0)
    indirect.irradiance[pixel] = kept
    excess[pixel] = light - kept


def take_fireflies(sps: ShadingPoints, sample: int, indirect: Indirect, excess: wp.array) -> None:
    """Move what fireflies of frame `sample` of a still view have too much from the irradiance of `sps` to `excess`.

    excess (pixel,) [W/m²]: left as it is at pixels without an SP; indirect: as the SPs were shaded, with what their
    rays found.
    """
    launch(take_fireflies_kernel, sps.capacity, [sps.points, sample, FIREFLY_PARAMETERS, indirect, excess], sps.device)

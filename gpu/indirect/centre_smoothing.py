"""What centres gather, shared between those side by side as far as it differs by no more than the noise of their rays.

Each centre has rays of its own, so that what few of them find, as of a lamp's shade close by, would be blotches as wide
as centres are apart.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import Representatives, level_of
from gpu.clustering.nearest import nearest_search
from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.indirect.final_gather import Gathered

# Centres that are looked at, one of them the centre itself.
CENTRES = 8

centres_about = nearest_search(CENTRES)


@wp.struct
@dataclass
class SmoothingParameters:
    """reach: in spacings of centres; deviations: of two centres' light, beyond which they share next to nothing."""

    reach: float = 2.5
    deviations: float = 1.0


SMOOTHING_PARAMETERS: SmoothingParameters = parameters(SmoothingParameters)


@wp.kernel
def smooth_centre_kernel(first: int, centres: Representatives, gathered: Gathered, chosen: SmoothingParameters,
                         irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a centre: its irradiance (centre,) [W/m²] and that of the ones about it, by distance and noise."""
    centre = first + wp.tid()
    irradiance[centre] = gathered.irradiance[centre]
    spacing = centres.spacing[centre]
    if spacing <= 0.0:
        return
    own = brightness(gathered.irradiance[centre])
    light = gathered.irradiance[centre]
    total = float(1.0)
    found = centres_about(centres, centres.position[centre], centres.normal[centre], level_of(centres.chosen, spacing))
    for place in range(wp.static(CENTRES)):
        other = found.cluster[place]
        if other >= 0 and other != centre:
            off = brightness(gathered.irradiance[other]) - own
            noise = gathered.variance[centre] + gathered.variance[other]
            way = found.distance[place] / (chosen.reach * spacing)
            unlike = off * off / wp.max(chosen.deviations * chosen.deviations * noise, 1.0e-20)
            weight = wp.max(1.0 - way * way, 0.0) * wp.exp(-unlike)
            light += gathered.irradiance[other] * weight
            total += weight
    irradiance[centre] = light / total


def smooth_centres(centres: Representatives, gathered: Gathered, irradiance: wp.array,
                   chosen: SmoothingParameters = SMOOTHING_PARAMETERS) -> None:  # fmt: skip
    """Share the irradiance that is `gathered` between `centres`; irradiance (centre,): to work with."""
    launch(smooth_centre_kernel, len(irradiance), [centres, gathered, chosen, irradiance], irradiance.device)
    wp.copy(gathered.irradiance, irradiance)

"""What gather rays read where they end: the irradiance there, if anything tells of it."""

from typing import Any, Protocol

import warp as wp


@wp.struct
class IrradianceEstimate:
    """irradiance: of a surface point [W/m²]; earlier: what of that is not of the last bounce, so it may be reflected
    once more; known: whether anything tells of it, else both are 0.
    """

    irradiance: wp.vec3
    earlier: wp.vec3
    known: bool


class Illumination(Protocol):
    """What rays read: lookup(lit, position, normal), an IrradianceEstimate of a surface point.

    data: the Warp struct type of `lit`.
    """

    lookup: wp.Function
    data: Any
    lit: Any

"""What gather rays read where they end: the irradiance there, if anything tells of it."""

from typing import Any, Protocol

import warp as wp


@wp.struct
class Told:
    """irradiance of a surface point [W/m²]; earlier: what of that is not of the last bounce, so it may be reflected
    once more; known: whether anything tells of it, else both are 0.
    """

    irradiance: wp.vec3
    earlier: wp.vec3
    known: bool


class Illumination(Protocol):
    """What rays read: lookup(lit, position, normal), a Told; lit: of Warp struct `data`."""

    lookup: wp.Function
    data: Any
    lit: Any

"""Real spherical harmonics of the first four bands: 2009 paper, section 3.4.

Constants as in R. Ramamoorthi and P. Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001.
"""

from typing import Any

import warp as wp

COUNT = 16
Harmonics: Any = wp.types.vector(length=COUNT, dtype=float)


@wp.func
def harmonics_at(direction: wp.vec3) -> Harmonics:
    """Values of all of them in a unit direction, band by band."""
    x = direction[0]
    y = direction[1]
    z = direction[2]
    return Harmonics(
        0.2820947918,
        0.4886025119 * y,
        0.4886025119 * z,
        0.4886025119 * x,
        1.0925484306 * x * y,
        1.0925484306 * y * z,
        0.3153915653 * (3.0 * z * z - 1.0),
        1.0925484306 * x * z,
        0.5462742153 * (x * x - y * y),
        0.5900435899 * y * (3.0 * x * x - y * y),
        2.8906114426 * x * y * z,
        0.4570457995 * y * (5.0 * z * z - 1.0),
        0.3731763326 * z * (5.0 * z * z - 3.0),
        0.4570457995 * x * (5.0 * z * z - 1.0),
        1.4453057213 * z * (x * x - y * y),
        0.5900435899 * x * (x * x - 3.0 * y * y),
    )

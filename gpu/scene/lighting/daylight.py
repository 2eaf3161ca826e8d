"""The sky of a clear day as a picture, by where the sun stands: of an edit that gives a sky a date.

A. Preetham, P. Shirley and B. Smits, "A practical analytic model for daylight", 1999, appendix A.2: R. Perez' formula
for luminance and chromaticity, fitted to simulated skies. It knows no sun below the horizon: the sky of a sun on it
gets darker then as measured twilight does. Below the horizon is a matt ground that reflects a fifth.
"""

from functools import lru_cache
from math import cos, pi, radians, sin, tan

import numpy as np

from gpu.scene.types import Doubles, Environment, Floats, Sky

HEIGHT = 64  # of the picture [pixels]
TURBIDITY = 2.5  # of a clear sky, as gpu.scene.lighting.sun takes it
_GROUND = 0.2
# Of Y, x and y: A to E of Perez' formula by turbidity, slope and value at 0.
_PEREZ = np.array(
    [
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
    ]
)
# Chromaticity of the zenith by powers of turbidity, from 2 to 0, and of the sun's angle from it, from 3 to 0.
_ZENITH_X = np.array(
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]
)
_ZENITH_Y = np.array(
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]
)
_TO_RGB = np.array(  # Rec. 709 from CIE XYZ
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)
_LEVEL = 5.0 / 6.0  # of what an even sky would send to level ground, a Sky does
# Of a sun this far below the horizon no light is left of the day's, and so much goes with each degree [°].
_DARK, _TWILIGHT = -18.0, 10.0**0.345


@lru_cache(maxsize=16)
def daylight(height: float, bearing: float) -> Floats:
    """Radiance (row, column, 3) of the sky with the sun so high above the horizon, and so far from −Z clockwise as seen
    from above [°], equirectangular as an Environment's; the sun itself is not in it.

    Its unit is such that a level surface gets π from the sky of a sun overhead, as from one of radiance 1. The same
    sun has the same array, so that it is known to be the same.
    """
    pixels = np.asarray(_radiance(height, bearing) * (pi / level_irradiance(_radiance(90.0, 0.0)).mean()), np.float32)
    pixels.setflags(write=False)
    return pixels


@lru_cache(maxsize=2)  # each edit of a sun asks again
def level_radiance(sky: Sky | Environment) -> float:
    """Of an even sky that would send level ground as much as `sky`, the mean of its channels."""
    if isinstance(sky, Sky):
        return _LEVEL * float(np.mean(sky.radiance))
    return float(np.mean(sky.tint * level_irradiance(sky.pixels))) / pi


def level_irradiance(picture: Doubles | Floats) -> Doubles:
    """Of a level surface under the upper half of an equirectangular `picture` (row, column, 3), (3,)."""
    rows = len(picture)
    ends = np.minimum(np.arange((rows + 1) // 2 + 1) * (pi / rows), pi / 2.0)
    shares = pi * np.diff(np.sin(ends) ** 2)  # of rows: cosine by solid angle
    return np.asarray((picture[: len(shares)].mean(axis=1, dtype=np.float64) * shares[:, None]).sum(axis=0))


def _radiance(height: float, bearing: float) -> Doubles:
    """As `daylight`, in the unit of the formula, of luminance [kcd/m²]."""
    rows, columns = HEIGHT, 2 * HEIGHT
    down = (np.arange(rows // 2) + 0.5) * pi / rows  # from the zenith
    # Columns go clockwise from −Z, as bearings do.
    around = (np.arange(columns) + 0.5) * 2.0 * pi / columns - radians(bearing)
    sun = radians(90.0 - min(max(height, 0.0), 90.0))
    cosine = np.cos(down)[:, None] * cos(sun) + np.outer(np.sin(down), np.cos(around)) * sin(sun)
    away = np.arccos(np.clip(cosine, -1.0, 1.0))
    coefficients = _PEREZ @ (TURBIDITY, 1.0)
    powers = TURBIDITY ** np.arange(2, -1, -1), sun ** np.arange(3, -1, -1)
    zenith = _zenith_luminance(sun), powers[0] @ _ZENITH_X @ powers[1], powers[0] @ _ZENITH_Y @ powers[1]
    luminance, x, y = (
        most * _perez(five, np.cos(down)[:, None], away) / _perez(five, np.ones(1), np.full(1, sun))
        for most, five in zip(zenith, coefficients, strict=True)
    )
    xyz = np.stack([x / y, np.ones_like(x), (1.0 - x - y) / y], axis=-1) * luminance[..., None]
    sky = np.maximum(xyz @ _TO_RGB.T, 0.0)
    picture = np.concatenate([sky, np.zeros_like(sky)])
    picture[rows // 2 :] = _GROUND / pi * level_irradiance(picture)
    return np.asarray(picture * _TWILIGHT ** max(min(height, 0.0), _DARK))


def _zenith_luminance(sun: float) -> float:
    """Of a sun so far from the zenith [kcd/m²]."""
    angle = (4.0 / 9.0 - TURBIDITY / 120.0) * (pi - 2.0 * sun)
    return (4.0453 * TURBIDITY - 4.9710) * tan(angle) - 0.2155 * TURBIDITY + 2.4192


def _perez(five: Doubles, up: Doubles, away: Doubles) -> Doubles:
    """Perez' formula of its five coefficients; up: cosine of the angle from the zenith; away: angle from the sun."""
    a, b, c, d, e = five
    return np.asarray((1.0 + a * np.exp(b / up)) * (1.0 + c * np.exp(d * away) + e * np.cos(away) ** 2))

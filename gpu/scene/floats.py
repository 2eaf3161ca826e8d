"""Numbers of files in double precision."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.scene.types import Doubles, Rgb


def doubles(values: NDArray[Any]) -> Doubles:
    """`values` as float64. Any bytes of a broken file may be a signalling NaN, which becomes a NaN like others."""
    with np.errstate(invalid="ignore"):
        return values.astype(np.float64)


def triple(values: Sequence[Any] | NDArray[Any]) -> Rgb:
    """The first three numbers of `values`, a colour, place or direction, as plain floats."""
    return (float(values[0]), float(values[1]), float(values[2]))

"""Numbers of binary files in double precision."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.scene.types import Doubles


def doubles(values: NDArray[Any]) -> Doubles:
    """`values` as float64. Any bytes of a broken file may be a signalling NaN, which becomes a NaN like others."""
    with np.errstate(invalid="ignore"):
        return values.astype(np.float64)

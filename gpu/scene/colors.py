"""Colours as displays encode them, and as light adds up."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.scene.types import Doubles


def srgb_to_linear(levels: NDArray[Any]) -> Doubles:
    """Levels 0–255 encoded as sRGB (IEC 61966-2-1), any shape, as linear values 0–1."""
    values = levels / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)

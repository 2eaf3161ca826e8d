"""Colours as displays encode them, and as light adds up."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.scene.types import Doubles, Texture

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
"""Chromaticities x, y of red, green, blue and white (ITU-R BT.709), as OpenEXR files have them."""


def srgb_to_linear(levels: NDArray[Any]) -> Doubles:
    """Levels 0–255 encoded as sRGB (IEC 61966-2-1), any shape, as linear values 0–1."""
    values = levels / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def mean_color(texture: Texture) -> Doubles:
    """The mean of a texture's pixels, (4,): linear red, green and blue, and alpha."""
    linear = srgb_to_linear(np.arange(256)) if texture.srgb else np.arange(256) / 255.0
    levels = [linear] * 3 + [np.arange(256) / 255.0]
    counts = [np.bincount(texture.pixels[:, :, channel].reshape(-1), minlength=256) for channel in range(4)]
    return np.array([count @ level / count.sum() for count, level in zip(counts, levels, strict=True)])

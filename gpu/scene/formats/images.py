"""Image files to pixels."""

import io
import warnings

import numpy as np
from PIL import Image, UnidentifiedImageError

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Bytes, Integers
from gpu.scene.validate import check_count

FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "TGA")


def decode_image(content: bytes, source: str, field: str, limits: SceneLimits) -> Bytes:
    """Pixels (height, width, 4) uint8 of an image file, top row first; 16-bit channels lose their lower byte.

    Raises SceneError naming `source` and `field` when it cannot be decoded, ForbiddenError when it is larger than
    `limits` allow.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of broken metadata, without which the first picture is as good
            with Image.open(io.BytesIO(content), formats=FORMATS) as image:
                place, side, pixels = f"{source}: {field}", max(image.size), image.width * image.height
                check_count(place, "pixels along one side", side, limits.max_texture_size, "max_texture_size")
                check_count(place, "pixels", pixels, limits.max_texture_pixels, "max_texture_pixels")
                if image.mode.startswith("I"):
                    return _from_16_bit(np.asarray(image))
                return np.asarray(image.convert("RGBA"))
    except SceneError:
        raise
    except UnidentifiedImageError as error:
        raise SceneError(source, field, f"not an image that can be read, which are {', '.join(FORMATS)}") from error
    except Image.DecompressionBombError as error:
        raise ForbiddenError(source, field, f"too large to be decoded: {error}") from error
    except Exception as error:  # decoders raise whatever they like on broken files
        raise SceneError(source, field, f"not an image that can be read: {error}") from error


def _from_16_bit(grey: Integers) -> Bytes:
    """Grey levels (height, width) of 16 bits as (height, width, 4) uint8."""
    level = (grey.astype(np.uint32) >> 8).astype(np.uint8)
    return np.stack([level, level, level, np.full_like(level, 255)], axis=-1)


def fitted(channel: Bytes, like: Bytes) -> Bytes:
    """`channel` (height, width) at the size of `like`, by the nearest pixel."""
    rows, columns = (np.arange(new) * old // new for new, old in zip(like.shape, channel.shape, strict=False))
    return channel[rows[:, None], columns]

"""KTX 2 images of Basis Universal codecs (ETC1S, UASTC), as KHR_texture_basisu has them, by opengl-basisu, an extra."""

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.extras import library
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Bytes
from gpu.scene.validate import check_count

IDENTIFIER = b"\xabKTX 20\xbb\r\n\x1a\n"
"""What every KTX 2 file starts with."""


def decode_ktx2(content: bytes, source: str, field: str, limits: SceneLimits) -> Bytes:
    """Pixels (height, width, 4) uint8 of the largest level of a KTX 2 image, top row first.

    Raises SceneError naming `source` and `field` when it cannot be decoded or the extra is not installed,
    ForbiddenError when it is larger than `limits` allow.
    """
    basisu = library(source, "opengl_basisu", "ktx2")
    try:
        texture = basisu.open(content)
        place, width, height = f"{source}: {field}", texture.width, texture.height
        check_count(place, "pixels along one side", max(width, height), limits.max_texture_size, "max_texture_size")
        check_count(place, "pixels", width * height, limits.max_texture_pixels, "max_texture_pixels")
        if texture.faces > 1 or texture.layers > 1:
            raise SceneError(source, field, "a cube map or array, which no surface can show")
        return np.asarray(texture.transcode("rgba8").data)
    except (ValueError, IndexError) as error:
        raise SceneError(source, field, f"not a KTX 2 image that can be read: {error}") from error

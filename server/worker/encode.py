"""From a rendered picture to the bytes that leave the worker."""

import numpy as np
import simplejpeg
from numpy.typing import NDArray

from server.images import encode_image
from server.wire.worker import Output

FINE_QUALITY = 90


def encode(
    pixels: NDArray[np.uint8] | None, radiance: NDArray[np.float32] | None, output: Output, quality: int
) -> bytes:
    """The picture in the format `output`, empty for "none"; `quality` (1 to 100) is for "jpeg".

    pixels: (height, width, 3) sRGB, for "jpeg", "rgb", ".png" and ".jpg"; radiance: the same shape, linear, for the
    others. Below FINE_QUALITY a "jpeg" trades a little colour resolution for speed and size: 4:2:0 and the fast DCT.
    It has no colour profile, which would be half a kilobyte a frame: browsers take a picture without one for sRGB.
    Releases the GIL.
    """
    if output == "none":
        return b""
    if output == "rgb":
        assert pixels is not None
        return pixels.tobytes()
    if output != "jpeg":
        return encode_image(pixels, radiance, output)
    fine = quality >= FINE_QUALITY
    assert pixels is not None
    return simplejpeg.encode_jpeg(
        np.ascontiguousarray(pixels), quality, "RGB", "444" if fine else "420", fastdct=not fine
    )

"""From a rendered picture to the bytes that leave the worker."""

import numpy as np
import simplejpeg
from numpy.typing import NDArray

from server.images import encode_image
from server.messages import Output


def encode(
    pixels: NDArray[np.uint8] | None, radiance: NDArray[np.float32] | None, output: Output, quality: int
) -> bytes:
    """The picture in the format `output`; `quality` (1 to 100) is for streamed JPEGs.

    pixels: (height, width, 3) sRGB, for "stream", ".png" and ".jpg"; radiance: the same shape, linear, for the others.
    Streamed frames trade a little colour resolution for speed and size: 4:2:0 and the fast DCT. Releases the GIL.
    """
    if output != "stream":
        return encode_image(pixels, radiance, output)
    assert pixels is not None
    return simplejpeg.encode_jpeg(
        np.ascontiguousarray(pixels), quality, colorspace="RGB", colorsubsampling="420", fastdct=True
    )

"""H.264 for viewers who walk: each picture a packet of its own, made at once, from what it differs in from the last.

libx264 by PyAV. At 640×360 a picture takes about 2.5 ms of a core and, while the camera moves, a tenth of the bytes
of a JPEG of quality 80.
"""

from fractions import Fraction
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from server.video.pictures import VideoError, av_library, say_colours, video_frame

# Constant quality: 23 is libx264's own. zerolatency: no pictures are held back, and none refers to a later one.
OPTIONS = {"preset": "ultrafast", "tune": "zerolatency", "profile": "baseline", "crf": "23", "threads": "1"}
NO_KEY_FRAMES = 2**30  # but those that are asked for


def can_encode_video() -> bool:
    """Whether this host has what live video takes."""
    return find_spec("av") is not None


class LiveVideo:
    """The videos of viewers, by number. Pictures of one viewer must come in turn; those of several may come at once."""

    def __init__(self) -> None:
        self._encoders: dict[int, _Encoder] = {}

    def encode(self, viewer: int, number: int, pixels: NDArray[np.uint8]) -> tuple[bytes, bool]:
        """A picture (height, width, 3) in sRGB as H.264 (Annex B), and whether it needs no earlier one to be decoded.

        That is so where the picture encoded last for the viewer was of another size, or not the one before `number`.
        An odd side is made even by doubling its last pixels. Raises VideoError where it cannot be encoded.
        """
        even = _even(pixels)
        encoder = self._encoders.pop(viewer, None)  # what fails is not used again
        is_key = encoder is None or encoder.shape != even.shape or encoder.number + 1 != number
        if encoder is None or is_key:
            encoder = _Encoder(even.shape)
        data = encoder.encode(even, number)
        self._encoders[viewer] = encoder
        return data, is_key

    def forget(self, viewer: int) -> None:
        """Free what is kept for a viewer."""
        self._encoders.pop(viewer, None)


class _Encoder:
    """Of pictures of one size, the first of which is a key frame."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        av = av_library()
        self.shape, self.number = shape, 0
        self._errors: tuple[type[Exception], ...] = (OSError, av.error.FFmpegError)
        self._context: Any = av.CodecContext.create("libx264", "w")
        self._context.height, self._context.width = shape[:2]
        self._context.time_base = Fraction(1, 1000)
        self._context.gop_size = NO_KEY_FRAMES
        self._context.options = OPTIONS
        say_colours(self._context)
        self._pictures = 0

    def encode(self, pixels: NDArray[np.uint8], number: int) -> bytes:
        frame = video_frame(pixels)
        frame.pts, self.number = self._pictures, number
        self._pictures += 1
        try:
            packets = self._context.encode(frame)
        except self._errors as error:
            raise VideoError(f"a picture of {pixels.shape[1]}×{pixels.shape[0]} cannot be encoded: {error}") from None
        return b"".join(bytes(packet) for packet in packets)


def _even(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width, _ = pixels.shape
    if height % 2 == 0 and width % 2 == 0:
        return pixels
    return np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")

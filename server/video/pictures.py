"""Pictures on their way into a video, by PyAV, which is the optional extra `video`.

What is encoded is 4:2:0 of 8 bits and of limited range, which every player has, and says whose colours it is: the
primaries and matrix of BT.709, the tone curve of sRGB (ITU-T H.273, tables 2 to 4).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.errors import UserError

PIXEL_FORMAT = "yuv420p"
# Code points of ITU-T H.273, as PyAV takes them.
BT_709, SRGB, LIMITED_RANGE = 1, 13, 1


class VideoError(UserError):
    """A video cannot be made."""


def av_library() -> Any:
    """The module `av`; VideoError with what to install where it is missing."""
    try:
        import av
    except ImportError:
        raise VideoError("video needs the extra video: pip install lumenwalk[video]") from None
    return av


def check_size(size: tuple[int, int]) -> None:
    """VideoError unless both sides (width, height) are even: two pixels share a colour difference along each."""
    width, height = size
    if width % 2 or height % 2:
        even = f"{width + width % 2}x{height + height % 2}"
        raise VideoError(f"size: a video needs even sides, which {width}x{height} has not; ask for {even}")


def say_colours(context: Any) -> None:
    """Have an encoder's context write whose colours its stream has."""
    context.pix_fmt = PIXEL_FORMAT
    context.color_primaries, context.color_trc, context.colorspace = BT_709, SRGB, BT_709
    context.color_range = LIMITED_RANGE


def video_frame(pixels: NDArray[np.uint8]) -> Any:
    """An av.VideoFrame in PIXEL_FORMAT of a picture (height, width, 3) in sRGB, copied."""
    frame = av_library().VideoFrame.from_ndarray(np.ascontiguousarray(pixels), "rgb24")
    return frame.reformat(
        format=PIXEL_FORMAT,
        src_colorspace="ITU709",
        dst_colorspace="ITU709",
        src_color_range="JPEG",
        dst_color_range="MPEG",
    )

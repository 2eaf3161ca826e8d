"""Radiance pictures (.hdr): four bytes a pixel, three mantissas with a common exponent (G. Ward, Real Pixels, 1991)."""

import re

import numpy as np

from gpu.errors import ImageError
from gpu.scene.types import Bytes, Floats

_RESOLUTION = re.compile(rb"-Y (\d{1,6}) \+X (\d{1,6})\n")
_MOST_HEADER = 1 << 16
_LEAST_CODED, _MOST_CODED = 8, 0x7FFF  # widths of lines that are coded in runs


def read_radiance(content: bytes, source: str, max_pixels: int) -> Floats:
    """Linear radiance (height, width, 3) of a file's content, top row first.

    Raises ImageError naming `source` where that is no such picture, has more pixels, or is cut off.
    """
    if not content.startswith((b"#?RADIANCE", b"#?RGBE")):
        raise ImageError(f"{source}: is no Radiance picture, which begins with #?RADIANCE")
    end = content.find(b"\n\n", 0, _MOST_HEADER)
    found = _RESOLUTION.match(content, end + 2) if end >= 0 else None
    if found is None:
        raise ImageError(f"{source}: has no line such as “-Y 512 +X 1024”; other orders of pixels are not read")
    if b"FORMAT=32-bit_rle_xyze" in content[:end]:
        raise ImageError(f"{source}: its colours are XYZ, which is not read; convert it to RGB")
    height, width = int(found[1]), int(found[2])
    if not 0 < height * width <= max_pixels:
        raise ImageError(f"{source}: has {width} x {height} pixels; 1 to {max_pixels:,} are read; make it smaller")
    try:
        pixels = _pixels(content, found.end(), height, width)
    except (IndexError, ValueError) as error:
        raise ImageError(f"{source}: is cut off or damaged") from error
    scale = np.ldexp(np.float32(1.0), pixels[..., 3:].astype(np.int32) - 136)
    return np.asarray(np.where(pixels[..., 3:] > 0, pixels[..., :3] * scale, 0.0), np.float32)


def _pixels(content: bytes, place: int, height: int, width: int) -> Bytes:
    """All pixels (height, width, 4) uint8. IndexError or ValueError where there are too few or too many."""
    data = np.frombuffer(content, np.uint8)
    coded = _LEAST_CODED <= width <= _MOST_CODED and content[place : place + 2] == b"\x02\x02"
    if not coded:
        flat = data[place : place + height * width * 4]
        if (flat[0::4] & flat[1::4] & flat[2::4] == 1).any() and (flat.reshape(-1, 4)[:, :3] == 1).all(axis=1).any():
            raise ValueError("runs of the oldest kind")
        return flat.reshape(height, width, 4)
    lines = np.empty((height, 4, width), np.uint8)
    for line in lines:
        if content[place : place + 4] != bytes((2, 2, width >> 8, width & 255)):
            raise ValueError("not coded in runs as the others")
        place = _line(content, data, place + 4, line.reshape(-1))
    return lines.transpose(0, 2, 1)


def _line(content: bytes, data: Bytes, place: int, line: Bytes) -> int:
    """Unpack a line's runs into `line` (4 · width,), one channel after the other, and return where they end."""
    filled, wanted = 0, len(line)
    while filled < wanted:
        count = content[place]
        if count > 128:
            count -= 128
            line[filled : filled + count] = content[place + 1]
            place += 2
        else:
            line[filled : filled + count] = data[place + 1 : place + 1 + count]
            place += 1 + count
        if count == 0 or filled + count > wanted:
            raise ValueError("a run beyond its line")
        filled += count
    return place

import numpy as np
import pytest

from gpu.errors import ImageError
from gpu.scene.lighting.radiance_hdr import read_radiance
from gpu.scene.types import Bytes

HEAD = b"#?RADIANCE\n# by hand\nFORMAT=32-bit_rle_rgbe\n\n"


def runs(channel: bytes) -> bytes:
    """A channel of a line: repeated bytes as runs, others as they are."""
    out, place = b"", 0
    while place < len(channel):
        end = place + 1
        while end < len(channel) and channel[end] == channel[place] and end - place < 127:
            end += 1
        out += bytes((128 + end - place, channel[place])) if end - place > 1 else bytes((1, channel[place]))
        place = end
    return out


def coded(pixels: Bytes) -> bytes:
    """A file of pixels (height, width, 4), coded in runs."""
    height, width = pixels.shape[:2]
    lines = [bytes((2, 2, width >> 8, width & 255)) + b"".join(runs(bytes(line[:, k])) for k in range(4))
             for line in pixels]  # fmt: skip
    return HEAD + f"-Y {height} +X {width}\n".encode() + b"".join(lines)


def some(height: int = 4, width: int = 300) -> Bytes:
    rng = np.random.default_rng(1)
    return np.repeat(rng.integers(1, 256, (height, width // 4, 4)), 4, axis=1).astype(np.uint8)


def test_mantissas_share_an_exponent() -> None:
    flat = np.array([[[128, 64, 0, 129], [255, 1, 2, 0]]], np.uint8)
    content = HEAD + b"-Y 1 +X 2\n" + flat.tobytes()
    assert read_radiance(content, "sky", 2).tolist() == [[[1.0, 0.5, 0.0], [0.0, 0.0, 0.0]]]


def test_lines_of_runs_are_those_of_plain_pixels() -> None:
    pixels = some()
    plain = HEAD + b"-Y 4 +X 300\n" + pixels.tobytes()
    expected = pixels[..., :3] * 2.0 ** (pixels[..., 3:].astype(float) - 136.0)
    for content in (coded(pixels), plain):
        assert np.allclose(read_radiance(content, "sky", 1200), expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"P6 1 1 255\n", "is no Radiance picture"),
        (HEAD + b"+Y 4 +X 300\n", "has no line such as"),
        (HEAD.replace(b"rgbe", b"xyze") + b"-Y 1 +X 2\n", "XYZ"),
        (HEAD + b"-Y 0 +X 2\n", "has 2 x 0 pixels"),
        (HEAD + b"-Y 99999 +X 99999\n", "make it smaller"),
        (coded(some())[:-3], "cut off or damaged"),
        (HEAD + b"-Y 2 +X 2\n" + bytes(7), "cut off or damaged"),
        (HEAD + b"-Y 1 +X 8\n\x02\x02\x00\x08" + b"\xff\x07" * 9, "cut off or damaged"),
        (HEAD + b"-Y 1 +X 8\n\x02\x02\x00\x08" + b"\x00\x07" * 9, "cut off or damaged"),
        (HEAD + b"-Y 1 +X 8\n\x02\x02\x00\x09" + b"\x88\x07" * 9, "cut off or damaged"),
        (HEAD + b"-Y 1 +X 2\n\x01\x01\x01\x05" + bytes(4), "cut off or damaged"),
    ],
)
def test_what_cannot_be_read_is_said(content: bytes, problem: str) -> None:
    with pytest.raises(ImageError, match=f"^sky: .*{problem}"):
        read_radiance(content, "sky", 1 << 20)

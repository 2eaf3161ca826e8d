import io

import numpy as np
import pytest
from isal import isal_zlib
from PIL import Image

from server.png import encode_png

RNG = np.random.default_rng(3)


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (5, 1), (33, 50)])
def test_every_pixel_comes_back(size: tuple[int, int]) -> None:
    pixels = RNG.integers(0, 256, (*size, 3), np.uint8)
    with Image.open(io.BytesIO(encode_png(pixels))) as image:
        image.verify()  # checksums too
    with Image.open(io.BytesIO(encode_png(pixels))) as image:
        assert image.mode == "RGB"
        assert np.array_equal(np.asarray(image), pixels)


def test_a_noisy_ramp_takes_far_fewer_bytes_than_without_a_filter() -> None:
    pixels = (np.linspace(0, 250, 160)[None, :, None] + RNG.integers(0, 2, (120, 160, 3))).astype(np.uint8)
    assert len(encode_png(pixels)) < 0.6 * len(isal_zlib.compress(pixels, 1))


def test_rows_of_a_view_are_read_as_they_lie() -> None:
    pixels = RNG.integers(0, 256, (6, 10, 3), np.uint8)[:, ::2]
    with Image.open(io.BytesIO(encode_png(pixels))) as image:
        assert np.array_equal(np.asarray(image), pixels)

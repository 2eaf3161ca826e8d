import io

import numpy as np
import pytest
import simplejpeg
from PIL import Image

from server.wire.worker import Output
from server.worker.encode import encode

RAMP = np.linspace(0.0, 1.0, 48 * 32, dtype=np.float32).reshape(32, 48, 1).repeat(3, axis=2)
PIXELS = (255 * RAMP).astype(np.uint8)


def test_a_streamed_frame_is_a_jpeg_of_the_wanted_quality() -> None:
    low, high = (encode(PIXELS, None, "jpeg", quality) for quality in (30, 95))
    assert len(low) < len(high)
    assert simplejpeg.decode_jpeg_header(high)[:2] == (32, 48)
    assert np.abs(simplejpeg.decode_jpeg(high).astype(int) - PIXELS).mean() < 3.0


@pytest.mark.parametrize(("output", "format_"), [(".png", "PNG"), (".jpg", "JPEG")])
def test_stills_for_display(output: Output, format_: str) -> None:
    assert Image.open(io.BytesIO(encode(PIXELS, None, output, 50))).format == format_


def test_linear_stills_keep_every_bit() -> None:
    np.testing.assert_array_equal(np.load(io.BytesIO(encode(None, RAMP, ".npy", 50))), RAMP)


def test_pictures_of_a_film_are_bytes_of_their_pixels() -> None:
    flipped = encode(PIXELS[::-1], None, "rgb", 50)
    np.testing.assert_array_equal(np.frombuffer(flipped, np.uint8).reshape(32, 48, 3), PIXELS[::-1])


def test_a_view_with_strides_is_encoded_as_it_looks() -> None:
    flipped = encode(PIXELS[::-1, :, ::-1], None, "jpeg", 95)
    assert flipped == encode(np.ascontiguousarray(PIXELS[::-1, :, ::-1]), None, "jpeg", 95)

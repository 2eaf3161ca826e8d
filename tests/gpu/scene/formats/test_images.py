import io

import numpy as np
import pytest
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.formats.images import decode_image, fitted
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits


def encoded(image: Image.Image, kind: str = "PNG", **options: object) -> bytes:
    file = io.BytesIO()
    image.save(file, kind, **options)
    return file.getvalue()


def decoded(content: bytes, limits: SceneLimits = DEFAULT_LIMITS) -> np.ndarray:
    return decode_image(content, "scene", "images[0]", limits)


def test_rows_run_from_the_top() -> None:
    image = Image.fromarray(np.array([[[1, 2, 3]], [[4, 5, 6]]], np.uint8))
    assert decoded(encoded(image)).tolist() == [[[1, 2, 3, 255]], [[4, 5, 6, 255]]]


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA"])
def test_every_mode_becomes_four_bytes(mode: str) -> None:
    pixels = decoded(encoded(Image.new(mode, (3, 2), 1 if mode == "1" else 0)))
    assert pixels.shape == (2, 3, 4)
    assert pixels.dtype == np.uint8


def test_sixteen_bits_keep_the_upper_eight() -> None:
    image = Image.fromarray(np.array([[0x1234, 0xFFFF]], np.uint16))
    assert decoded(encoded(image)).tolist() == [[[0x12] * 3 + [255], [255] * 4]]


@pytest.mark.parametrize("kind", ["JPEG", "WEBP"])
def test_formats(kind: str) -> None:
    pixels = decoded(encoded(Image.new("RGB", (8, 8), (200, 100, 50)), kind))
    assert np.allclose(pixels[..., :3], (200, 100, 50), atol=6)


@pytest.mark.parametrize(
    "limits", [SceneLimits(max_texture_size=99), SceneLimits(max_texture_pixels=9_999)], ids=["side", "pixels"]
)
def test_a_large_image_is_refused_before_it_is_decoded(limits: SceneLimits) -> None:
    with pytest.raises(SceneError, match=r"scene: images\[0\].*more than the"):
        decoded(encoded(Image.new("L", (100, 100))), limits)


def test_an_image_made_to_exhaust_memory() -> None:
    content = bytearray(encoded(Image.new("1", (1, 1))))
    content[16:24] = (60_000).to_bytes(4, "big") * 2
    with pytest.raises(SceneError, match=r"images\[0\]"):
        decoded(bytes(content))


def test_a_jpeg_with_a_broken_index_of_more_pictures_is_its_first() -> None:
    content = encoded(Image.new("RGB", (8, 8), (200, 100, 50)), "JPEG")
    index = b"MPF\0" + b"II*\0" + b"\xff\xff\xff\x7f"
    content = content[:2] + b"\xff\xe2" + (len(index) + 2).to_bytes(2, "big") + index + content[2:]
    assert np.allclose(decoded(content)[..., :3], (200, 100, 50), atol=6)


def test_of_several_pictures_the_first_is_read() -> None:
    first, second = (Image.new("RGB", (8, 8), color) for color in ((200, 100, 50), (0, 0, 0)))
    content = encoded(first, "MPO", save_all=True, append_images=[second])
    assert np.allclose(decoded(content)[..., :3], (200, 100, 50), atol=6)


@pytest.mark.parametrize("content", [b"", b"GIF89a", encoded(Image.new("RGB", (9, 9)))[:45]])
def test_what_cannot_be_decoded(content: bytes) -> None:
    with pytest.raises(SceneError, match=r"scene: images\[0\]: not an image that can be read"):
        decoded(content)


def test_a_channel_is_fitted_to_another_size_by_the_nearest_pixel() -> None:
    channel = np.array([[1, 2], [3, 4]], np.uint8)
    assert fitted(channel, np.zeros((4, 2, 4), np.uint8)).tolist() == [[1, 2], [1, 2], [3, 4], [3, 4]]

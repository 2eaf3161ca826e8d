import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.core.image_size import ImageSize, column_of, image_size, is_inside, pixel_at, row_of, tile_of


def test_a_size_is_width_then_height() -> None:
    image = image_size((7, 5))
    assert (image.width, image.height) == (7, 5)


@wp.kernel
def place_kernel(first: int, image: ImageSize, places: wp.array[wp.vec3i], pixels: wp.array[int],
                 inside: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel: its tile, column and row there, which pixel that is, and whether all about it are inside."""
    pixel = first + wp.tid()
    place = wp.vec3i(tile_of(pixel, image), column_of(pixel, image), row_of(pixel, image))
    places[pixel] = place
    pixels[pixel] = pixel_at(place[0], place[1], place[2], image)
    inside[pixel] = int(is_inside(place[1] - 1, place[2] - 1, image) and is_inside(place[1] + 1, place[2] + 1, image))


def test_pixels_are_numbered_row_by_row_tile_after_tile() -> None:
    tiles, width, height = 3, 7, 5
    count = tiles * width * height
    places = wp.zeros(count, dtype=wp.vec3i, device="cpu")
    pixels, inside = (wp.zeros(count, dtype=int, device="cpu") for _ in range(2))
    launch(place_kernel, count, [image_size((width, height)), places, pixels, inside], places.device)
    tile, row, column = np.indices((tiles, height, width)).reshape(3, -1)
    assert np.array_equal(places.numpy(), np.stack([tile, column, row], axis=1))
    assert np.array_equal(pixels.numpy(), np.arange(count))
    middle = (column > 0) & (column < width - 1) & (row > 0) & (row < height - 1)
    assert np.array_equal(inside.numpy(), middle)

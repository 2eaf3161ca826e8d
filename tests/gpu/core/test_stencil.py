import numpy as np
import warp as wp
from scenes import results

from gpu.core.image_size import ImageSize, image_size
from gpu.core.stencil import binomial_weight, nearest_beside, pixel_beside

SIZE = WIDTH, HEIGHT = 5, 4
PIXELS = WIDTH * HEIGHT
ROWS, COLUMNS = np.divmod(np.arange(PIXELS)[:, None], WIDTH)
DOWN, RIGHT = np.divmod(np.arange(9), 3)[0] - 1, np.arange(9) % 3 - 1


@wp.kernel
def stencil_kernel(first: int, step: int, image: ImageSize, out: wp.array[int]) -> None:
    """One thread a pair of a pixel and a number: the pixel there."""
    index = first + wp.tid()
    out[index] = pixel_beside(index // 9, index % 9, step, image)


@wp.kernel
def clamped_stencil_kernel(first: int, image: ImageSize, out: wp.array[int]) -> None:
    """One thread a pair of a pixel and a number: the pixel nearest to there."""
    index = first + wp.tid()
    out[index] = nearest_beside(index // 9, index % 9, image)


@wp.kernel
def binomial_kernel(first: int, out: wp.array[float]) -> None:
    """One thread a number: its weight."""
    number = first + wp.tid()
    out[number] = binomial_weight(number)


def test_pixels_beside_one_are_numbered_row_by_row_and_none_is_outside() -> None:
    for step in (1, 2):
        found = results(stencil_kernel, 9 * PIXELS, [step, image_size(SIZE)], wp.int32).reshape(PIXELS, 9)
        rows, columns = ROWS + step * DOWN, COLUMNS + step * RIGHT
        inside = (rows >= 0) & (rows < HEIGHT) & (columns >= 0) & (columns < WIDTH)
        assert np.array_equal(found, np.where(inside, rows * WIDTH + columns, -1))


def test_at_the_border_the_nearest_pixel_stands_for_what_is_outside() -> None:
    found = results(clamped_stencil_kernel, 9 * PIXELS, [image_size(SIZE)], wp.int32).reshape(PIXELS, 9)
    rows, columns = np.clip(ROWS + DOWN, 0, HEIGHT - 1), np.clip(COLUMNS + RIGHT, 0, WIDTH - 1)
    assert np.array_equal(found, rows * WIDTH + columns)


def test_weights_are_those_of_both_axes() -> None:
    weights = results(binomial_kernel, 9, [], float).reshape(3, 3)
    assert np.array_equal(weights / 16.0, np.outer([0.25, 0.5, 0.25], [0.25, 0.5, 0.25]))

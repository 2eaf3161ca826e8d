"""The size of an image, as kernels take it, and its tiles: pictures of one size, each by a camera of its own."""

import warp as wp


@wp.struct
class ImageSize:
    """Width and height of a tile [pixels]. Pixels are numbered row by row from its top left, tile after tile."""

    width: int
    height: int


def image_size(size: tuple[int, int]) -> ImageSize:
    """The struct of `size` (width, height)."""
    result = ImageSize()
    result.width, result.height = size
    return result


@wp.func
def tile_of(pixel: int, image: ImageSize) -> int:
    """The tile that a pixel is in."""
    return pixel // (image.width * image.height)


@wp.func
def column_of(pixel: int, image: ImageSize) -> int:
    """A pixel's column in its tile."""
    return pixel % image.width


@wp.func
def row_of(pixel: int, image: ImageSize) -> int:
    """A pixel's row in its tile."""
    return (pixel // image.width) % image.height


@wp.func
def pixel_at(tile: int, column: int, row: int, image: ImageSize) -> int:
    """The pixel of a tile at a column and row of it."""
    return (tile * image.height + row) * image.width + column


@wp.func
def is_inside(column: int, row: int, image: ImageSize) -> bool:
    """Whether a tile has such a column and row."""
    return column >= 0 and column < image.width and row >= 0 and row < image.height

"""The size of an image, as kernels take it."""

import warp as wp


@wp.struct
class ImageSize:
    """Width and height [pixels]. Pixels are numbered row by row from the top left."""

    width: int
    height: int


def image_size(size: tuple[int, int]) -> ImageSize:
    """The struct of `size` (width, height)."""
    result = ImageSize()
    result.width, result.height = size
    return result

"""The 3×3 pixels about one, which filters of images read: numbered 0 … 8 row by row, the pixel itself is 4."""

import warp as wp

from gpu.core.image_size import ImageSize


@wp.func
def pixel_beside(pixel: int, number: int, step: int, image: ImageSize) -> int:
    """Pixel `number` of the 3×3, `step` pixels apart, about one; −1 outside of the image."""
    x = pixel % image.width + (number % 3 - 1) * step
    y = pixel // image.width + (number // 3 - 1) * step
    if x >= 0 and x < image.width and y >= 0 and y < image.height:
        return y * image.width + x
    return -1


@wp.func
def nearest_beside(pixel: int, number: int, image: ImageSize) -> int:
    """Pixel `number` of the 3×3 about one; at the image's border the nearest there is."""
    x = wp.clamp(pixel % image.width + number % 3 - 1, 0, image.width - 1)
    y = wp.clamp(pixel // image.width + number // 3 - 1, 0, image.height - 1)
    return y * image.width + x


@wp.func
def binomial_weight(number: int) -> float:
    """What pixel `number` of the 3×3 counts where each axis counts 1/4, 1/2, 1/4, in sixteenths: 4 for the middle."""
    return float((2 - wp.abs(number % 3 - 1)) * (2 - wp.abs(number // 3 - 1)))

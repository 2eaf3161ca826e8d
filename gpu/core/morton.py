"""Morton order of pixels and of surface points: neighbours follow each other, for coherent rays and shared reads."""

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.device import launch

EMPTY_KEY = wp.constant(0x7FFFFFFF)
CELLS = wp.constant(512)
AXIS_BITS = wp.constant(9)
# Keys alike but for so many bits are of one direction and one of 32 × 32 × 32 cells.
CELL_BITS = 12
CELL_COUNT = 6 << (3 * int(AXIS_BITS) - CELL_BITS)


@wp.func
def spread_bits_3d(x: int) -> int:
    """The ten lowest bits, each followed by two zeros."""
    x = (x | (x << 16)) & 0x030000FF
    x = (x | (x << 8)) & 0x0300F00F
    x = (x | (x << 4)) & 0x030C30C3
    return (x | (x << 2)) & 0x09249249


@wp.func
def dominant_axis(normal: wp.vec3) -> int:
    """Which of the six axis directions a normal is nearest to, 0 to 5."""
    size = wp.vec3(wp.abs(normal[0]), wp.abs(normal[1]), wp.abs(normal[2]))
    axis = int(2)
    if size[0] >= size[1] and size[0] >= size[2]:
        axis = 0
    elif size[1] >= size[2]:
        axis = 1
    return 2 * axis + wp.where(normal[axis] < 0.0, 1, 0)


@wp.func
def morton_key(position: wp.vec3, normal: wp.vec3) -> int:
    """A point's place on a Z-order curve through unit space, below EMPTY_KEY.

    There is one curve for each of the six directions that normals mostly point to, so that neighbours in the order are
    not the two sides of a wall or of its corner.
    """
    p = (position + wp.vec3(0.5, 0.5, 0.5)) * float(CELLS)
    x = spread_bits_3d(wp.clamp(int(p[0]), 0, CELLS - 1))
    y = spread_bits_3d(wp.clamp(int(p[1]), 0, CELLS - 1))
    z = spread_bits_3d(wp.clamp(int(p[2]), 0, CELLS - 1))
    return (dominant_axis(normal) << (3 * AXIS_BITS)) | x | (y << 1) | (z << 2)


@wp.func
def spread_bits_2d(x: int) -> int:
    """The 16 lowest bits, each followed by a zero."""
    x = (x | (x << 8)) & 0x00FF00FF
    x = (x | (x << 4)) & 0x0F0F0F0F
    x = (x | (x << 2)) & 0x33333333
    return (x | (x << 1)) & 0x55555555


@wp.func
def morton_2d(x: int, y: int) -> int:
    """The number of a pixel in Morton's order, of coordinates below 2¹⁵."""
    return spread_bits_2d(x) | (spread_bits_2d(y) << 1)


@wp.func
def gathered_bits_2d(x: int) -> int:
    """Every second bit from the lowest on, side by side: what `spread_bits_2d` spread."""
    x = x & 0x55555555
    x = (x | (x >> 1)) & 0x33333333
    x = (x | (x >> 2)) & 0x0F0F0F0F
    x = (x | (x >> 4)) & 0x00FF00FF
    return (x | (x >> 8)) & 0x0000FFFF


@wp.func
def pixel_of_morton_2d(code: int) -> wp.vec2i:
    """Column and row of the pixel that has a number, below 2³⁰, in Morton's order."""
    return wp.vec2i(gathered_bits_2d(code), gathered_bits_2d(code >> 1))


@wp.kernel
def pixel_code_kernel(first: int, width: int, codes: wp.array[int], pixels: wp.array[int]) -> None:
    """One thread a pixel: its number in Morton's order, and its own; codes, pixels (pixel,)."""
    pixel = first + wp.tid()
    codes[pixel] = morton_2d(pixel % width, pixel // width)
    pixels[pixel] = pixel


def morton_order(size: tuple[int, int], device: wp.Device) -> wp.array:
    """The pixels of an image of `size` (width, height) in Morton's order, (pixel,) int."""
    count = size[0] * size[1]
    codes = wp.zeros(2 * count, dtype=int, device=device)
    pixels = wp.zeros(2 * count, dtype=int, device=device)
    launch(pixel_code_kernel, count, [size[0], codes, pixels], device)
    radix_sort_pairs(codes, pixels, count)
    return wp.clone(pixels[:count])

"""Irradiance between shading points: pixels whose neighbours on the same surface tell it have no SP of their own.

Indirect light changes little from pixel to pixel, so every STRIDE-th pixel of a row and a column, an anchor, is enough
where a surface is continuous; elsewhere a pixel is shaded itself. The light is interpolated as irradiance, which every
pixel reflects by its own albedo.
"""

import warp as wp

from gpu.gbuffer import GBuffer, reflectance
from gpu.kinship import kinship
from gpu.resident import NO_HIT

STRIDE = 2
# Smaller pictures show too little between two pixels for it to be even, and are quickly shaded whole.
LEAST_PIXELS = 1 << 17
# A pixel whose anchors have less of a share in it than this, of 1 for those of one plane, is shaded itself.
LEAST_SHARE = wp.constant(0.75)
# How far off its plane a pixel still shows a surface, in its spacings a step: a lamp lies deeper than its frame.
PLANE_TOLERANCE = wp.constant(0.1)


def stride_of(pixels: int) -> int:
    """Of the anchors of a picture of so many pixels; 1 where each pixel is one."""
    return STRIDE if pixels >= LEAST_PIXELS else 1


@wp.struct
class Corner:
    """One of the four anchors around a pixel: its pixel and its share in the one between."""

    pixel: int
    share: float


@wp.func
def corner_of(gbuffer: GBuffer, pixel: int, number: int, width: int, height: int, stride: int) -> Corner:
    """Anchor `number`, 0 … 3, of the cell that holds `pixel`: bilinear weight times kinship, 0 beyond the image."""
    corner = Corner()
    x = pixel % width
    y = pixel // width
    column = (x // stride + number % 2) * stride
    row = (y // stride + number // 2) * stride
    if column >= width or row >= height:
        return corner
    across = 1.0 - wp.abs(float(x - column)) / float(stride)
    down = 1.0 - wp.abs(float(y - row)) / float(stride)
    corner.pixel = row * width + column
    if across * down > 0.0:
        corner.share = across * down * kinship(gbuffer, pixel, corner.pixel, stride, PLANE_TOLERANCE)
    return corner


@wp.func
def is_shaded(gbuffer: GBuffer, pixel: int, width: int, height: int, stride: int) -> bool:
    """Whether a pixel with a surface has an SP of its own: an anchor, or one whose anchors are of other surfaces."""
    if (pixel % width) % stride == 0 and (pixel // width) % stride == 0:
        return True
    total = float(0.0)
    for number in range(4):
        total += corner_of(gbuffer, pixel, number, width, height, stride).share
    return total < LEAST_SHARE


@wp.func
def is_even(listed: wp.array[int], pixel: int, width: int, height: int) -> bool:
    """Whether none of the pixels beside an SP's has one, so that it speaks for them: listed (pixel,) is 1 where any."""
    column = pixel % width
    row = pixel // width
    for neighbour in range(9):
        x = wp.clamp(column + neighbour % 3 - 1, 0, width - 1)
        y = wp.clamp(row + neighbour // 3 - 1, 0, height - 1)
        other = y * width + x
        if other != pixel and listed[other] == 1:
            return False
    return True


@wp.func
def irradiance_at(gbuffer: GBuffer, pixel: int, width: int, height: int, stride: int,
                  irradiance: wp.array[wp.vec3]) -> wp.vec3:  # fmt: skip
    """Irradiance of a pixel with a surface: its own, or that of its anchors. irradiance (pixel,): of those with SPs."""
    if is_shaded(gbuffer, pixel, width, height, stride):
        return irradiance[pixel]
    total = float(0.0)
    light = wp.vec3(0.0, 0.0, 0.0)
    for number in range(4):
        corner = corner_of(gbuffer, pixel, number, width, height, stride)
        if corner.share > 0.0:
            total += corner.share
            light += irradiance[corner.pixel] * corner.share
    return light / total


@wp.kernel
def reflect_kernel(first: int, gbuffer: GBuffer, width: int, height: int, stride: int, irradiance: wp.array[wp.vec3],
                   radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: adds what its surface reflects of the irradiance, its own or that of its anchors.

    irradiance (pixel,): of those with SPs [W/m²]; radiance (pixel,): towards the camera [W/m²/sr].
    """
    pixel = first + wp.tid()
    if gbuffer.face[pixel] != NO_HIT:
        light = irradiance_at(gbuffer, pixel, width, height, stride, irradiance)
        radiance[pixel] += wp.cw_mul(reflectance(gbuffer, pixel), light)

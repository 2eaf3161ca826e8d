"""Irradiance between shading points: pixels whose neighbours on the same surface tell it have no SP of their own.

Indirect light changes little from pixel to pixel, so every STRIDE-th pixel of a row and a column, an anchor, is enough
where a surface is continuous; elsewhere a pixel is shaded itself. The light is interpolated as irradiance, which every
pixel reflects by its own albedo.

Where light ends between anchors, above a lamp or below a table, a pixel between them has not the mean of both. That is
seen when its light is known; frames that follow shade such pixels, too: 0.1 to 0.5 percent of a picture, which hold a
tenth of its squared error.
"""

import warp as wp

from gpu.core.color import brightness
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, image_point
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, reflectance

STRIDE = 2
# Smaller pictures show too little between two pixels for it to be even, and are quickly shaded whole.
LEAST_PIXELS = 1 << 17
# A pixel whose anchors have less of a share in it than this, of 1 for those of one plane, is shaded itself.
LEAST_SHARE = wp.constant(0.75)
# How far off its plane a pixel still shows a surface, in its spacings a step: a lamp lies deeper than its frame.
PLANE_TOLERANCE = wp.constant(0.1)
# Light ends between anchors of which one has so many times another's, where that is more than a share of the picture's
# mean brightness: by 1.5 times are twice the pixels, and no less error.
UNLIKE, LEAST_UNLIKE = wp.constant(2.0), wp.constant(0.1)


def stride_of(pixels: int) -> int:
    """Of the anchors of a picture of so many pixels; 1 where each pixel is one."""
    return STRIDE if pixels >= LEAST_PIXELS else 1


@wp.struct
class Anchor:
    """One of the four anchors around a pixel: its pixel and its share in the one between."""

    pixel: int
    share: float


@wp.func
def anchor_of(gbuffer: GBuffer, pixel: int, number: int, width: int, height: int, stride: int) -> Anchor:
    """Anchor `number`, 0 … 3, of the cell that holds `pixel`: bilinear weight times edge_stopping_weight, 0 beyond
    the image.
    """
    corner = Anchor()
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
        corner.share = across * down * edge_stopping_weight(gbuffer, pixel, corner.pixel, stride, PLANE_TOLERANCE)
    return corner


@wp.func
def is_anchor(pixel: int, width: int, stride: int) -> bool:
    """Whether a pixel is one of those that tell others."""
    return (pixel % width) % stride == 0 and (pixel // width) % stride == 0


@wp.func
def is_shaded(gbuffer: GBuffer, pixel: int, width: int, height: int, stride: int) -> bool:
    """Whether a pixel with a surface has an SP whatever its light: an anchor, or one whose anchors are of others."""
    if is_anchor(pixel, width, stride):
        return True
    total = float(0.0)
    for number in range(4):
        total += anchor_of(gbuffer, pixel, number, width, height, stride).share
    return total < LEAST_SHARE


@wp.func
def is_anchor_only(listed: wp.array[int], pixel: int, width: int, height: int) -> bool:
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


@wp.struct
class Interpolated:
    """What a pixel's anchors tell of its irradiance: the mean, their share in it, the least and greatest brightness."""

    light: wp.vec3
    share: float
    least: float
    most: float


@wp.func
def between(gbuffer: GBuffer, pixel: int, width: int, height: int, stride: int,
            irradiance: wp.array[wp.vec3]) -> Interpolated:  # fmt: skip
    """The irradiance (pixel,) of a pixel's anchors on its surface."""
    found = Interpolated()
    for number in range(4):
        corner = anchor_of(gbuffer, pixel, number, width, height, stride)
        if corner.share > 0.0:
            light = irradiance[corner.pixel]
            amount = brightness(light)
            found.least = wp.where(found.share > 0.0, wp.min(found.least, amount), amount)
            found.most = wp.max(found.most, amount)
            found.share += corner.share
            found.light += light * corner.share
    found.light /= wp.max(found.share, 1.0e-20)
    return found


@wp.func
def irradiance_at(gbuffer: GBuffer, pixel: int, width: int, height: int, stride: int, listed: wp.array[int],
                  irradiance: wp.array[wp.vec3]) -> wp.vec3:  # fmt: skip
    """Irradiance of a pixel with a surface: its own, or that of its anchors.

    listed (pixel,): 1 for those with SPs; irradiance (pixel,): of these.
    """
    if listed[pixel] == 1:
        return irradiance[pixel]
    return between(gbuffer, pixel, width, height, stride, irradiance).light


@wp.func
def light_ended(before: wp.array[CameraData], irradiance_edges: wp.array[wp.uint8], position: wp.vec3, width: int,
                height: int) -> bool:  # fmt: skip
    """Whether light `irradiance_edges` (pixel,), in the image of the camera `before` (1,), at a pixel around this
    position.
    """
    place = image_point(before[0], position, width, height)
    if place[0] <= -1.0 or place[1] <= -1.0:
        return False
    column = int(wp.max(place[0], 0.0))
    row = int(wp.max(place[1], 0.0))
    for corner in range(4):
        x = wp.min(column + corner % 2, width - 1)
        y = wp.min(row + corner // 2, height - 1)
        if irradiance_edges[y * width + x] == wp.uint8(1):
            return True
    return False


@wp.kernel
def reflect_kernel(first: int, gbuffer: GBuffer, width: int, height: int, stride: int, listed: wp.array[int],
                   irradiance: wp.array[wp.vec3], mean: wp.array[float], irradiance_edges: wp.array[wp.uint8],
                   radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: adds what its surface reflects of the irradiance, its own or that of its anchors.

    listed (pixel,): 1 for pixels with SPs; irradiance (pixel,): of these [W/m²]; mean (1,): brightness of the picture;
    ends (pixel,): becomes 1 where light ends between anchors, else 0; radiance (pixel,): to the camera [W/m²/sr].
    """
    pixel = first + wp.tid()
    irradiance_edges[pixel] = wp.uint8(0)
    if gbuffer.face[pixel] == NO_HIT:
        return
    light = irradiance[pixel]
    reflected = reflectance(gbuffer, pixel)
    if not is_anchor(pixel, width, stride):
        around = between(gbuffer, pixel, width, height, stride, irradiance)
        if around.share >= LEAST_SHARE:
            unlike = (around.most - around.least) * brightness(reflected)
            if around.most > UNLIKE * around.least and unlike > LEAST_UNLIKE * mean[0]:
                irradiance_edges[pixel] = wp.uint8(1)
            if listed[pixel] == 0:
                light = around.light
    radiance[pixel] += wp.cw_mul(reflected, light)

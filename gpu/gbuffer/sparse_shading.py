"""Irradiance between shading points: pixels whose neighbours on the same surface tell it have no SP of their own.

Indirect light changes little from pixel to pixel, so every STRIDE-th pixel of a row and a column, an anchor, is enough
where a surface is continuous; elsewhere a pixel is shaded itself. The light is interpolated as irradiance, which every
pixel reflects by its own albedo.

Where light ends between anchors, above a lamp or below a table, a pixel between them has not the mean of both. That is
seen when its light is known; frames that follow shade such pixels, too: 0.1 to 0.5 percent of a picture, which hold a
tenth of its squared error.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.image_size import ImageSize
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, image_point
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, reflectance

# The anchors' distance, in pictures of so many pixels or more: smaller ones show too little between two pixels for it
# to be even, and are quickly shaded whole.
STRIDE, LEAST_PIXELS = 2, 1 << 17


@wp.struct
@dataclass
class SparseShadingParameters:
    """Where pixels have SPs of their own. stride: distance of the anchors [pixels]; with 1 all pixels are anchors.

    min_share: a pixel whose anchors weigh less than this together, 1 being those of one plane, is shaded itself;
    plane_tolerance: how far off its plane a pixel still shows a surface, in its spacings a step: a lamp lies deeper
    than its frame; edge_ratio, min_edge: light ends between anchors of which one has so many times another's, where the
    difference is more than a share of the picture's mean brightness: by 1.5 times are twice the pixels, and no less
    error.
    """

    stride: int = 1
    min_share: float = 0.75
    plane_tolerance: float = 0.1
    edge_ratio: float = 2.0
    min_edge: float = 0.1


def stride_of(pixels: int) -> int:
    """Of the anchors of a picture of so many pixels; 1 where each pixel is one."""
    return STRIDE if pixels >= LEAST_PIXELS else 1


@wp.struct
class Anchor:
    """One of the four anchors around a pixel: its pixel and its share in the one between."""

    pixel: int
    share: float


@wp.func
def anchor_of(gbuffer: GBuffer, pixel: int, number: int, image: ImageSize, sparse: SparseShadingParameters) -> Anchor:
    """Anchor `number`, 0 … 3, of the cell that holds `pixel`: bilinear weight times edge_stopping_weight, 0 beyond
    the image.
    """
    corner = Anchor()
    x = pixel % image.width
    y = pixel // image.width
    column = (x // sparse.stride + number % 2) * sparse.stride
    row = (y // sparse.stride + number // 2) * sparse.stride
    if column >= image.width or row >= image.height:
        return corner
    across = 1.0 - wp.abs(float(x - column)) / float(sparse.stride)
    down = 1.0 - wp.abs(float(y - row)) / float(sparse.stride)
    corner.pixel = row * image.width + column
    if across * down > 0.0:
        corner.share = (
            across * down * edge_stopping_weight(gbuffer, pixel, corner.pixel, sparse.stride, sparse.plane_tolerance)
        )
    return corner


@wp.func
def is_anchor(pixel: int, image: ImageSize, sparse: SparseShadingParameters) -> bool:
    """Whether a pixel is one of those that tell others."""
    return (pixel % image.width) % sparse.stride == 0 and (pixel // image.width) % sparse.stride == 0


@wp.func
def is_shaded(gbuffer: GBuffer, pixel: int, image: ImageSize, sparse: SparseShadingParameters) -> bool:
    """Whether a pixel with a surface has an SP whatever its light: an anchor, or one whose anchors are of others."""
    if is_anchor(pixel, image, sparse):
        return True
    total = float(0.0)
    for number in range(4):
        total += anchor_of(gbuffer, pixel, number, image, sparse).share
    return total < sparse.min_share


@wp.func
def is_anchor_only(listed: wp.array[int], pixel: int, image: ImageSize) -> bool:
    """Whether none of the pixels beside an SP's has one, so that it speaks for them: listed (pixel,) is 1 where any."""
    column = pixel % image.width
    row = pixel // image.width
    for neighbour in range(9):
        x = wp.clamp(column + neighbour % 3 - 1, 0, image.width - 1)
        y = wp.clamp(row + neighbour // 3 - 1, 0, image.height - 1)
        other = y * image.width + x
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
def between(gbuffer: GBuffer, pixel: int, image: ImageSize, sparse: SparseShadingParameters,
            irradiance: wp.array[wp.vec3]) -> Interpolated:  # fmt: skip
    """The irradiance (pixel,) of a pixel's anchors on its surface."""
    found = Interpolated()
    for number in range(4):
        corner = anchor_of(gbuffer, pixel, number, image, sparse)
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
def irradiance_at(gbuffer: GBuffer, pixel: int, image: ImageSize, sparse: SparseShadingParameters,
                  listed: wp.array[int], irradiance: wp.array[wp.vec3]) -> wp.vec3:  # fmt: skip
    """Irradiance of a pixel with a surface: its own, or that of its anchors.

    listed (pixel,): 1 for those with SPs; irradiance (pixel,): of these.
    """
    if listed[pixel] == 1:
        return irradiance[pixel]
    return between(gbuffer, pixel, image, sparse, irradiance).light


@wp.struct
class PreviousEdges:
    """Where light ended in the frame before: edges (pixel,) 1 there, else 0, in the image of camera (1,).

    follows (1,): 1 where this frame sees much the same, so that light ends there still.
    """

    follows: wp.array[int]
    camera: wp.array[CameraData]
    edges: wp.array[wp.uint8]


@wp.func
def light_ended(before: PreviousEdges, position: wp.vec3, image: ImageSize) -> bool:
    """Whether light ended in the frame before at a pixel around this position."""
    place = image_point(before.camera[0], position, image)
    if place[0] <= -1.0 or place[1] <= -1.0:
        return False
    column = int(wp.max(place[0], 0.0))
    row = int(wp.max(place[1], 0.0))
    for corner in range(4):
        x = wp.min(column + corner % 2, image.width - 1)
        y = wp.min(row + corner // 2, image.height - 1)
        if before.edges[y * image.width + x] == wp.uint8(1):
            return True
    return False


@wp.kernel
def reflect_irradiance_kernel(first: int, gbuffer: GBuffer, image: ImageSize, sparse: SparseShadingParameters,
                   listed: wp.array[int], irradiance: wp.array[wp.vec3], mean: wp.array[float],
                   edges: wp.array[wp.uint8], radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: adds what its surface reflects of the irradiance, its own or that of its anchors.

    listed (pixel,): 1 for pixels with SPs; irradiance (pixel,): of these [W/m²]; mean (1,): brightness of the picture;
    edges (pixel,): becomes 1 where light ends between anchors, else 0; radiance (pixel,): to the camera [W/m²/sr].
    """
    pixel = first + wp.tid()
    edges[pixel] = wp.uint8(0)
    if gbuffer.face[pixel] == NO_HIT:
        return
    light = irradiance[pixel]
    reflected = reflectance(gbuffer, pixel)
    if not is_anchor(pixel, image, sparse):
        around = between(gbuffer, pixel, image, sparse, irradiance)
        if around.share >= sparse.min_share:
            unlike = (around.most - around.least) * brightness(reflected)
            if around.most > sparse.edge_ratio * around.least and unlike > sparse.min_edge * mean[0]:
                edges[pixel] = wp.uint8(1)
            if listed[pixel] == 0:
                light = around.light
    radiance[pixel] += wp.cw_mul(reflected, light)

"""Sparse shading: pixels between shading points take their irradiance from those around them on the same surface.

Indirect light changes little from pixel to pixel, so one pixel in two of each row and column, an anchor, is enough
where a surface is continuous; elsewhere every pixel is shaded itself. What is interpolated is irradiance, which each
pixel reflects by its own albedo.

Where light has an edge between anchors, above a lamp or below a table, the mean of both is wrong for the pixels between
them. The edge shows once the anchors are shaded, and later frames shade these pixels, too: 0.1 to 0.5 % of a picture,
which hold a tenth of its squared error.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.image_size import ImageSize
from gpu.core.stencil import nearest_beside
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, image_point
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, reflectance


@dataclass(frozen=True)
class AnchorParameters:
    """stride: distance of anchors [pixels] in pictures of min_pixels or more: smaller ones show too little between two
    pixels for it to be even, and are quickly shaded whole. The least frame of one viewer among many, 320×180 of any
    shape, is none of these.
    """

    stride: int = 2
    min_pixels: int = 50_000


ANCHOR_PARAMETERS = AnchorParameters()


@wp.struct
@dataclass
class SparseShadingParameters:
    """Which pixels have SPs of their own. stride: distance of the anchors [pixels]; with 1 every pixel is one.

    min_weight: a pixel whose anchors weigh less than this together is shaded itself; on a plane they weigh 1;
    plane_tolerance: how far off its plane a pixel still shows a surface, in its spacings a step: a lamp lies deeper
    than its frame; edge_ratio, min_edge: light has an edge between anchors when the brightest has so many times the
    irradiance of the darkest, and the difference in radiance is more than this share of the picture's mean. A ratio of
    1.5 shades twice as many pixels and leaves no less error.
    """

    stride: int
    min_weight: float = 0.75
    plane_tolerance: float = 0.1
    edge_ratio: float = 2.0
    min_edge: float = 0.1


def stride_of(pixels: int) -> int:
    """Of the anchors of a picture of so many pixels; 1 where each pixel is one."""
    return ANCHOR_PARAMETERS.stride if pixels >= ANCHOR_PARAMETERS.min_pixels else 1


@wp.struct
class Anchor:
    """One of the four anchors around a pixel: its own pixel and its weight."""

    pixel: int
    weight: float


@wp.func
def anchor_of(gbuffer: GBuffer, pixel: int, number: int, image: ImageSize, sparse: SparseShadingParameters) -> Anchor:
    """Anchor `number`, 0 … 3, of the cell that holds `pixel`.

    Its weight is bilinear, times edge_stopping_weight; 0 outside the image.
    """
    anchor = Anchor()
    x = pixel % image.width
    y = pixel // image.width
    column = (x // sparse.stride + number % 2) * sparse.stride
    row = (y // sparse.stride + number // 2) * sparse.stride
    if column >= image.width or row >= image.height:
        return anchor
    across = 1.0 - wp.abs(float(x - column)) / float(sparse.stride)
    down = 1.0 - wp.abs(float(y - row)) / float(sparse.stride)
    anchor.pixel = row * image.width + column
    if across * down > 0.0:
        anchor.weight = (
            across * down * edge_stopping_weight(gbuffer, pixel, anchor.pixel, sparse.stride, sparse.plane_tolerance)
        )
    return anchor


@wp.func
def is_anchor(pixel: int, image: ImageSize, sparse: SparseShadingParameters) -> bool:
    """Whether a pixel is an anchor."""
    return (pixel % image.width) % sparse.stride == 0 and (pixel // image.width) % sparse.stride == 0


@wp.func
def is_shaded(gbuffer: GBuffer, pixel: int, image: ImageSize, sparse: SparseShadingParameters) -> bool:
    """Whether a pixel with a surface has an SP whatever its light: an anchor, or one without anchors of its surface."""
    if is_anchor(pixel, image, sparse):
        return True
    total = float(0.0)
    for number in range(4):
        total += anchor_of(gbuffer, pixel, number, image, sparse).weight
    return total < sparse.min_weight


@wp.func
def is_anchor_only(listed: wp.array[int], pixel: int, image: ImageSize) -> bool:
    """Whether none of the eight pixels around an SP's pixel has an SP. listed (pixel,): 1 for pixels that have one."""
    for number in range(9):
        other = nearest_beside(pixel, number, image)
        if other != pixel and listed[other] == 1:
            return False
    return True


@wp.struct
class Interpolated:
    """Irradiance between anchors: their weighted mean, the sum of the weights, and the range of their brightness."""

    light: wp.vec3
    weight: float
    min_brightness: float
    max_brightness: float


@wp.func
def interpolated_irradiance(gbuffer: GBuffer, pixel: int, image: ImageSize, sparse: SparseShadingParameters,
                            irradiance: wp.array[wp.vec3]) -> Interpolated:  # fmt: skip
    """The `irradiance` (pixel,) of a pixel, interpolated between the anchors on its surface."""
    found = Interpolated()
    for number in range(4):
        anchor = anchor_of(gbuffer, pixel, number, image, sparse)
        if anchor.weight > 0.0:
            light = irradiance[anchor.pixel]
            bright = brightness(light)
            found.min_brightness = wp.where(found.weight > 0.0, wp.min(found.min_brightness, bright), bright)
            found.max_brightness = wp.max(found.max_brightness, bright)
            found.weight += anchor.weight
            found.light += light * anchor.weight
    found.light /= wp.max(found.weight, 1.0e-20)
    return found


@wp.func
def is_edge_between(around: Interpolated, reflected: wp.vec3, mean: float, sparse: SparseShadingParameters) -> bool:
    """Whether light has an edge between anchors, as a pixel shows them that reflects so much; mean: of the picture."""
    step = (around.max_brightness - around.min_brightness) * brightness(reflected)
    differ = around.max_brightness > sparse.edge_ratio * around.min_brightness
    return differ and step > sparse.min_edge * mean


@wp.func
def irradiance_at(gbuffer: GBuffer, pixel: int, image: ImageSize, sparse: SparseShadingParameters,
                  listed: wp.array[int], irradiance: wp.array[wp.vec3]) -> wp.vec3:  # fmt: skip
    """Irradiance of a pixel with a surface: its own, or that of its anchors.

    listed (pixel,): 1 for those with SPs; irradiance (pixel,): of these.
    """
    if listed[pixel] == 1:
        return irradiance[pixel]
    return interpolated_irradiance(gbuffer, pixel, image, sparse, irradiance).light


@wp.struct
class PreviousEdges:
    """Edges of light between anchors in the frame before: edges (pixel,), 1 there, else 0; camera (1,): of that frame.

    follows (1,): 1 when this frame sees much the same, so that the edges are still there.
    """

    follows: wp.array[int]
    camera: wp.array[CameraData]
    edges: wp.array[wp.uint8]


@wp.func
def is_at_edge(before: PreviousEdges, position: wp.vec3, image: ImageSize) -> bool:
    """Whether the frame before had an edge of light at one of the four pixels around `position`."""
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
    edges (pixel,): becomes 1 at edges of light, else 0; radiance (pixel,): to the camera [W/m²/sr].
    """
    pixel = first + wp.tid()
    edges[pixel] = wp.uint8(0)
    if gbuffer.face[pixel] == NO_HIT:
        return
    light = irradiance[pixel]
    reflected = reflectance(gbuffer, pixel)
    if not is_anchor(pixel, image, sparse):
        around = interpolated_irradiance(gbuffer, pixel, image, sparse, irradiance)
        if around.weight >= sparse.min_weight:
            edges[pixel] = wp.uint8(int(is_edge_between(around, reflected, mean[0], sparse)))
            if listed[pixel] == 0:
                light = around.light
    radiance[pixel] += wp.cw_mul(reflected, light)

"""Light shared between neighbouring pixels of one surface: what removes the speckle of few samples a pixel.

An edge-avoiding à-trous filter (H. Dammertz et al. 2010) over light that is divided by reflectance, guided by the noise
around each pixel (C. Schied et al. 2017): where neighbours agree, as beside a sharp shadow, nothing is mixed. What a
filter loses that guides itself gpu.denoise.lost_light gives back.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import duplicate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.parameters import parameters
from gpu.core.stencil import binomial_weight, pixel_beside
from gpu.denoise.lost_light import pair_weight, restore
from gpu.denoise.sparse_image import SparseImage, sparse_image
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.edge_stopping import edge_stopping_weight, gloss_weight
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import is_anchor_only

# Of the à-trous wavelet transform, each twice the one before; a launch each.
STEPS = (1, 2, 4)


@wp.struct
@dataclass
class AtrousParameters:
    """What neighbours share.

    plane_tolerance: how far off its plane a pixel still shows a surface, in its spacings a step; light_tolerance: light
    that differs by this many deviations is taken for other light, not for noise; guide_tolerance: guiding light may
    differ by this much, relatively.
    max_step: the most that the square of a step times the frames that light is of may be: the less noise light has, the
    nearer it is shared, since blur does not fade with frames. max_step_on_detail: the same for uneven surfaces and
    light that each SP has rays for in nearly every frame: these have more of that, which is worth less sharing.
    """

    plane_tolerance: float = 1.0
    light_tolerance: float = 3.0
    guide_tolerance: float = 1.0
    max_step: int = 80
    max_step_on_detail: int = 16


ATROUS_PARAMETERS: AtrousParameters = parameters(AtrousParameters)


@wp.kernel
def light_deviation_kernel(first: int, gbuffer: GBuffer, image: ImageSize, plane_tolerance: float,
                           light: wp.array[wp.vec3], deviation: wp.array[float]) -> None:  # fmt: skip
    """One thread a pixel: the standard deviation of the light (pixel,) of its surface in the 3×3 pixels around."""
    pixel = first + wp.tid()
    deviation[pixel] = 0.0
    if gbuffer.face[pixel] == NO_HIT:
        return
    total = float(0.0)
    mean = float(0.0)
    square = float(0.0)
    for number in range(9):
        other = pixel_beside(pixel, number, 1, image)
        if other >= 0:
            weight = edge_stopping_weight(gbuffer, pixel, other, 1, plane_tolerance)
            weight *= gloss_weight(gbuffer, pixel, other)
            value = brightness(light[other])
            total += weight
            mean += weight * value
            square += weight * value * value
    mean = mean / wp.max(total, 1.0e-20)
    deviation[pixel] = wp.sqrt(wp.max(square / wp.max(total, 1.0e-20) - mean * mean, 0.0))


@wp.kernel
def atrous_pixels_kernel(first: int, gbuffer: GBuffer, image: ImageSize, step: int, chosen: AtrousParameters,
                         light: wp.array[wp.vec3], deviation: wp.array[float],
                         out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: its light mixed with that of the eight pixels `step` away, by 1/4, 1/2, 1/4 on each axis.

    light, deviation, out (pixel,): the deviation as of `light_deviation_kernel`.
    """
    pixel = first + wp.tid()
    out[pixel] = light[pixel]
    if gbuffer.face[pixel] == NO_HIT or deviation[pixel] == 0.0:
        return
    own = brightness(light[pixel])
    tolerance = chosen.light_tolerance * deviation[pixel]
    total = float(4.0)
    mixed = light[pixel] * 4.0
    for number in range(9):
        other = pixel_beside(pixel, number, step, image)
        if other >= 0 and other != pixel:
            share = binomial_weight(number)
            weight = share * edge_stopping_weight(gbuffer, pixel, other, step, chosen.plane_tolerance)
            weight *= gloss_weight(gbuffer, pixel, other)
            weight *= wp.exp(-wp.abs(brightness(light[other]) - own) / tolerance)
            total += weight
            mixed += light[other] * weight
    out[pixel] = mixed / total


@wp.kernel
def spread_kernel(first: int, gbuffer: GBuffer, image: ImageSize, listed: wp.array[int], step: int,
                  plane_tolerance: float, light: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: as `atrous_pixels_kernel` does, whatever light others have, where both have an SP.

    listed (pixel,): 1 for these. What one pixel gets another gives: weights are of pairs, and the sum stays.
    """
    pixel = first + wp.tid()
    out[pixel] = light[pixel]
    if listed[pixel] == 0:
        return
    spread = light[pixel]
    for number in range(9):
        other = pixel_beside(pixel, number, step, image)
        if other >= 0:
            more = light[other] - light[pixel]
            # Of most pixels there is nothing to spread.
            if listed[other] == 1 and wp.length_sq(more) > 0.0:
                weight = pair_weight(gbuffer, pixel, other, step, plane_tolerance)
                spread += more * (weight * binomial_weight(number) / 16.0)
    out[pixel] = spread


@wp.func
def luminance_weight(own: float, other: float, tolerance: float) -> float:
    """How much of what a neighbour knows counts, 0 … 1, where a guide of little noise has `other` light there."""
    return wp.exp(-wp.abs(other - own) / (tolerance * own + 1.0e-30))


@wp.struct
class LightGuide:
    """What guides the sharing of light, (pixel,) each: other light there, which has little noise, and frames.

    frames: how many earlier frames the shared light is known of.
    """

    light: wp.array[wp.vec3]
    frames: wp.array[int]


@wp.kernel(module="unique", module_options={"fast_math": True})
def atrous_points_kernel(first: int, gbuffer: GBuffer, points: PointList, sparse: SparseImage, step: int,
                         guide: LightGuide, chosen: AtrousParameters, light: wp.array[wp.vec3],
                         out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: its light (pixel,) mixed with that of the nine anchors `step` strides about it.

    With step 0, that of the eight pixels beside it which have SPs, as all have where anchors tell little. Where the
    guide has other light nothing is mixed, nor far off where the light is a mean of more frames than this one; light of
    fewer frames counts less.
    """
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    width = sparse.image.width
    stride = sparse.stride
    even = stride == 1 or is_anchor_only(sparse.listed, pixel, sparse.image)
    reach = wp.where(even, chosen.max_step, chosen.max_step_on_detail)
    if step * step * (guide.frames[pixel] + 1) > reach:
        out[pixel] = light[pixel]
        return
    anchor = (pixel // width // stride * width + pixel % width // stride) * stride
    centre = wp.where(step > 0, anchor, pixel)
    away = wp.max(step * stride, 1)
    own = brightness(guide.light[pixel])
    total = float(4.0)
    mixed = light[pixel] * 4.0
    for number in range(9):
        other = pixel_beside(centre, number, away, sparse.image)
        if other >= 0 and other != pixel:
            has_light = step > 0 or sparse.listed[other] == 1
            if has_light:
                share = binomial_weight(number)
                weight = share * edge_stopping_weight(gbuffer, pixel, other, away, chosen.plane_tolerance)
                weight *= luminance_weight(own, brightness(guide.light[other]), chosen.guide_tolerance)
                weight *= wp.min(float(guide.frames[other] + 1) / float(guide.frames[pixel] + 1), 1.0)
                total += weight
                mixed += light[other] * weight
    out[pixel] = mixed / total


class Smoothing:
    """Smooths light of an image of `size` (width, height); its arrays are allocated once."""

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device, self._size, self._image = device, size, image_size(size)
        pixels = size[0] * size[1]
        self._deviation = wp.zeros(pixels, dtype=float, device=device)
        self._other = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._third = wp.zeros(pixels, dtype=wp.vec3, device=device)

    def run(self, gbuffer: GBuffer, light: wp.array, frames: wp.array) -> None:
        """Smooth `light` (pixel,), light per reflectance of what is in `gbuffer`, in place; as much of it is left.

        frames (pixel,): how many the light is the mean of; 0 counts as 1.
        """
        image, chosen, deviation = self._image, ATROUS_PARAMETERS, self._deviation
        inputs = [gbuffer, image, chosen.plane_tolerance, light, deviation]
        launch(light_deviation_kernel, len(light), inputs, self.device)
        source, target, other = light, self._other, self._third
        for step in STEPS:
            inputs = [gbuffer, image, step, chosen, source, deviation, target]
            launch(atrous_pixels_kernel, len(light), inputs, self.device)
            source, target, other = target, other, target
        restore(gbuffer, image, STEPS, chosen.plane_tolerance, light, source, target, frames)

    def spread(self, gbuffer: GBuffer, sps: ShadingPoints, light: wp.array) -> wp.array:
        """The `light` (pixel,) of `sps` spread over the SPs around on one surface, which have as much of it together;
        the next call overwrites the array.
        """
        source, target = light, self._other
        for step in STEPS:
            inputs = [gbuffer, self._image, sps.listed, step, ATROUS_PARAMETERS.plane_tolerance, source, target]
            launch(spread_kernel, len(light), inputs, self.device)
            source, target = target, self._third if target is self._other else self._other
        return source

    def share(self, gbuffer: GBuffer, sps: ShadingPoints, guide: wp.array, light: wp.array, frames: wp.array, *,
              nearer_on_detail: bool) -> wp.array:  # fmt: skip
        """The `light` (pixel,) of `sps` shared between neighbours of one surface; the next call overwrites the array.

        guide (pixel,): other light there, with little noise. Rare samples that guided themselves would lose a part of
        their mean. frames (pixel,): of how many earlier frames the light is known. With these it is shared nearer, and
        `nearer_on_detail` at uneven surfaces.
        """
        guides, sparse, chosen = LightGuide(), sparse_image(self._size, sps), ATROUS_PARAMETERS
        guides.light, guides.frames = guide, frames
        if not nearer_on_detail:
            chosen = duplicate(AtrousParameters, chosen)
            chosen.max_step_on_detail = chosen.max_step
        source, target = light, self._other
        for step in (0, *STEPS):
            inputs = [gbuffer, sps.points, sparse, step, guides, chosen, source, target]
            launch(atrous_points_kernel, sps.capacity, inputs, self.device)
            source, target = target, self._third if target is self._other else self._other
        return source

"""Soft light shared between neighbouring pixels of one surface: what removes the speckle of few samples a pixel.

An edge-avoiding à-trous filter (H. Dammertz et al. 2010) over light that is divided by reflectance, guided by the noise
around each pixel (C. Schied et al. 2017): where neighbours agree, as beside a sharp shadow, nothing is mixed.
"""

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.image_size import image_of
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import is_anchor_only

STEPS = (1, 2, 4)
# The most that the square of a step times the frames that light is of may be: the less noise light has, the nearer it
# is shared, since blur does not fade with frames. Uneven surfaces have more of that, which is worth less sharing for
# light that each SP has rays for in nearly every frame; near field's, with rays of few, is shared as usual.
MAX_STEP, MAX_STEP_ON_DETAIL = 80, 16
# How far off its plane a pixel still shows a surface, in its spacings a step.
PLANE_TOLERANCE = wp.constant(1.0)
# Light that differs by this many deviations is taken for other light, not for noise.
LIGHT_TOLERANCE = wp.constant(3.0)
# Guiding light may differ by this much, relatively.
GUIDE_TOLERANCE = wp.constant(1.0)


@wp.kernel
def deviation_kernel(first: int, gbuffer: GBuffer, width: int, height: int, light: wp.array[wp.vec3],
                     deviation: wp.array[float]) -> None:  # fmt: skip
    """One thread a pixel: the standard deviation of the light of its surface in the 3×3 pixels around."""
    pixel = first + wp.tid()
    deviation[pixel] = 0.0
    if gbuffer.face[pixel] == NO_HIT:
        return
    column = pixel % width
    row = pixel // width
    total = float(0.0)
    mean = float(0.0)
    square = float(0.0)
    for neighbour in range(9):
        x = column + neighbour % 3 - 1
        y = row + neighbour // 3 - 1
        if x >= 0 and x < width and y >= 0 and y < height:
            other = y * width + x
            weight = edge_stopping_weight(gbuffer, pixel, other, 1, PLANE_TOLERANCE)
            value = brightness(light[other])
            total += weight
            mean += weight * value
            square += weight * value * value
    mean = mean / wp.max(total, 1.0e-20)
    deviation[pixel] = wp.sqrt(wp.max(square / wp.max(total, 1.0e-20) - mean * mean, 0.0))


@wp.kernel
def smooth_kernel(first: int, gbuffer: GBuffer, width: int, height: int, step: int, light: wp.array[wp.vec3],
                  deviation: wp.array[float], out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: its light mixed with that of the eight pixels `step` away, by 1/4, 1/2, 1/4 on each axis."""
    pixel = first + wp.tid()
    out[pixel] = light[pixel]
    if gbuffer.face[pixel] == NO_HIT or deviation[pixel] == 0.0:
        return
    column = pixel % width
    row = pixel // width
    own = brightness(light[pixel])
    tolerance = LIGHT_TOLERANCE * deviation[pixel]
    total = float(4.0)
    mixed = light[pixel] * 4.0
    for neighbour in range(9):
        dx = neighbour % 3 - 1
        dy = neighbour // 3 - 1
        x = column + dx * step
        y = row + dy * step
        if neighbour != 4 and x >= 0 and x < width and y >= 0 and y < height:
            other = y * width + x
            share = float((2 - wp.abs(dx)) * (2 - wp.abs(dy)))
            weight = share * edge_stopping_weight(gbuffer, pixel, other, step, PLANE_TOLERANCE)
            weight *= wp.exp(-wp.abs(brightness(light[other]) - own) / tolerance)
            total += weight
            mixed += light[other] * weight
    out[pixel] = mixed / total


@wp.func
def luminance_weight(own: float, other: float) -> float:
    """How much of what a neighbour knows counts, 0 … 1, where a guide of little noise has `other` light there."""
    return wp.exp(-wp.abs(other - own) / (GUIDE_TOLERANCE * own + 1.0e-30))


@wp.kernel(module="unique", module_options={"fast_math": True})
def smooth_points_kernel(first: int, gbuffer: GBuffer, width: int, height: int, sps: wp.array[int],
                         count: wp.array[int], listed: wp.array[int], stride: int, step: int, frames: wp.array[int],
                         max_step_on_detail: int, guide: wp.array[wp.vec3], light: wp.array[wp.vec3],
                         out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: its light mixed with that of the nine anchors (gpu.gbuffer.sparse_shading) `step` strides
    about it.

    With step 0, that of the eight pixels beside it which have SPs, as all have where anchors tell little: listed
    (pixel,): 1. Where the `guide` (pixel,) has other light, of which it has little noise, nothing is mixed, nor far off
    where the light is a mean of more `frames` (pixel,) than this one; light of fewer frames counts less.
    """
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = sps[sp]
    reach = wp.where(
        stride == 1 or is_anchor_only(listed, pixel, image_of(width, height)), wp.static(MAX_STEP), max_step_on_detail
    )
    if step * step * (frames[pixel] + 1) > reach:
        out[pixel] = light[pixel]
        return
    x = pixel % width
    y = pixel // width
    own = brightness(guide[pixel])
    total = float(4.0)
    mixed = light[pixel] * 4.0
    for neighbour in range(9):
        dx = neighbour % 3 - 1
        dy = neighbour // 3 - 1
        column = x + dx
        row = y + dy
        if step > 0:
            column = (x // stride + dx * step) * stride
            row = (y // stride + dy * step) * stride
        if column >= 0 and column < width and row >= 0 and row < height:
            other = row * width + column
            if other != pixel and (step > 0 or listed[other] == 1):
                share = float((2 - wp.abs(dx)) * (2 - wp.abs(dy)))
                weight = share * edge_stopping_weight(gbuffer, pixel, other, wp.max(step * stride, 1), PLANE_TOLERANCE)
                weight *= luminance_weight(own, brightness(guide[other]))
                weight *= wp.min(float(frames[other] + 1) / float(frames[pixel] + 1), 1.0)
                total += weight
                mixed += light[other] * weight
    out[pixel] = mixed / total


class Smoothing:
    """Smooths light of an image of `size` (width, height); its arrays are allocated once."""

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device, self._size = device, size
        pixels = size[0] * size[1]
        self._deviation = wp.zeros(pixels, dtype=float, device=device)
        self._other = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._third = wp.zeros(pixels, dtype=wp.vec3, device=device)

    def run(self, gbuffer: GBuffer, light: wp.array) -> None:
        """Smooth `light` (pixel,), light per reflectance of the SPs in `gbuffer`, in place."""
        width, height = self._size
        pixels = width * height
        launch(deviation_kernel, pixels, [gbuffer, width, height, light, self._deviation], self.device)
        source, target = light, self._other
        for step in STEPS:
            inputs = [gbuffer, width, height, step, source, self._deviation, target]
            launch(smooth_kernel, pixels, inputs, self.device)
            source, target = target, source
        if source is not light:
            wp.copy(light, source)

    def share(self, gbuffer: GBuffer, sps: ShadingPoints, guide: wp.array, light: wp.array, frames: wp.array,
              max_step_on_detail: int = MAX_STEP) -> wp.array:  # fmt: skip
        """The `light` (pixel,) of `sps` shared between neighbours of one surface; the next call overwrites the array.

        guide (pixel,): other light there, with little noise. Rare samples that guided themselves would lose a part of
        their mean. frames (pixel,): of how many earlier frames the light is known. With these it is shared nearer, by
        `max_step_on_detail` on uneven surfaces, by MAX_STEP elsewhere.
        """
        source, target = light, self._other
        for step in (0, *STEPS):
            inputs = [gbuffer, *self._size, sps.pixels, sps.count, sps.listed, sps.stride, step, frames]
            inputs += [max_step_on_detail, guide, source, target]
            launch(smooth_points_kernel, sps.capacity, inputs, self.device)
            source, target = target, self._third if target is self._other else self._other
        return source

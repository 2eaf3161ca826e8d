"""Light that smoothing has lost, given back to the surface around, so that no place brightens or darkens by it.

A filter that is guided by the light which it smooths (gpu.denoise.atrous) takes rare bright samples for other light,
and so loses a part of their mean. What is lost is mostly noise, of which a wide mean, guided by surfaces alone, has
little. Added, that leaves the picture as smooth, its edges as sharp, and all parts of it as bright as before.
"""

import warp as wp

from gpu.core.device import launch
from gpu.core.image_size import ImageSize
from gpu.core.stencil import binomial_weight, pixel_beside
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.edge_stopping import edge_stopping_weight, gloss_weight
from gpu.gbuffer.gbuffer import GBuffer


@wp.func
def pair_weight(gbuffer: GBuffer, p: int, q: int, step: int, tolerance: float) -> float:
    """How far pixels `p` and `q`, `step` pixels apart, show one surface, 0 to 1: the same for both.

    tolerance: as of gpu.gbuffer.edge_stopping.edge_stopping_weight.
    """
    return wp.min(
        edge_stopping_weight(gbuffer, p, q, step, tolerance), edge_stopping_weight(gbuffer, q, p, step, tolerance)
    )


@wp.kernel
def lost_light_kernel(first: int, light: wp.array[wp.vec3], before: wp.array[wp.vec3], lost: wp.array[wp.vec3]) -> None:
    """One thread a pixel: what smoothed `light` lacks of that `before`, as `lost`; (pixel,) each."""
    pixel = first + wp.tid()
    lost[pixel] = before[pixel] - light[pixel]


@wp.kernel
def restore_kernel(first: int, gbuffer: GBuffer, image: ImageSize, step: int, plane_tolerance: float,
                   lost: wp.array[wp.vec3], frames: wp.array[int], light: wp.array[wp.vec3],
                   out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: what is `lost` (pixel,), mixed with that of the eight pixels `step` away.

    Weights are of pairs, so what one pixel gets another gives. light (pixel,): where it is given, what lacks that;
    `out` (pixel,) then has both together, else what is lost.
    Where few pixels around are of the surface it stays the noise that it was: the fewer `frames` (pixel,) the light is
    the mean of, the less of it is added.
    """
    pixel = first + wp.tid()
    spread = lost[pixel]
    shared = float(0.0)
    if gbuffer.face[pixel] != NO_HIT:
        for number in range(9):
            other = pixel_beside(pixel, number, step, image)
            if other >= 0 and other != pixel:
                weight = pair_weight(gbuffer, pixel, other, step, plane_tolerance)
                weight *= gloss_weight(gbuffer, pixel, other) * binomial_weight(number) / 16.0
                shared += weight
                spread += (lost[other] - lost[pixel]) * weight
    if light.shape[0] > 0:
        # All eight pixels have 3/4 together.
        believed = wp.min(shared / 0.75 * float(wp.max(frames[pixel], 1)), 1.0)
        out[pixel] = wp.max(light[pixel] + spread * believed, wp.vec3(0.0, 0.0, 0.0))
    else:
        out[pixel] = spread


def restore(gbuffer: GBuffer, image: ImageSize, steps: tuple[int, ...], plane_tolerance: float, light: wp.array,
            smoothed: wp.array, lost: wp.array, frames: wp.array) -> None:  # fmt: skip
    """Make of `light` (pixel,) the `smoothed` light (pixel,) with what that lacks of it; lost (pixel,): to work with.

    steps: of the mean, as of an à-trous filter, odd in number, so that it ends in `light`; frames (pixel,): how many
    the light is the mean of, 0 counts as 1.
    """
    device = light.device
    launch(lost_light_kernel, len(light), [smoothed, light, lost], device)
    source, target = lost, light
    for step in steps:
        lacking = smoothed if step == steps[-1] else None
        inputs = [gbuffer, image, step, plane_tolerance, source, frames, lacking, target]
        launch(restore_kernel, len(light), inputs, device)
        source, target = target, source

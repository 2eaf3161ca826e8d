"""Soft direct light of a walk: the mean of what its frames found where they saw the same surface
(gpu.denoise.reprojection).

A pixel has one or two shadow rays a frame. Where a lamp is seen by few of them, or a penumbra is wide, that leaves dots
and ragged edges which no smoothing of a single frame removes.
"""

from copy import copy

import warp as wp

from gpu.core.device import launch
from gpu.denoise.reprojection import (
    LEAST_SHARE,
    MOST_FRAMES,
    PreviousFrame,
    PreviousFrameData,
    bilinear_tap,
    blend,
    previous_place,
)
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer

# Frames for a roughness of 1: what a specular lobe reflects moves with the view, the sooner the narrower it is.
FRAMES_A_ROUGHNESS = wp.constant(16.0)


@wp.func
def most_frames(gbuffer: GBuffer, pixel: int) -> int:
    """How many frames the light of a pixel may be the mean of."""
    if wp.max(gbuffer.f0[pixel]) == 0.0:
        return MOST_FRAMES
    return wp.clamp(int(FRAMES_A_ROUGHNESS * gbuffer.roughness[pixel]), 1, MOST_FRAMES)


@wp.kernel
def take_kernel(first: int, gbuffer: GBuffer, past: PreviousFrameData, remembers: bool, width: int, height: int,
                past_frames: wp.array[int], past_light: wp.array[wp.vec3], frames: wp.array[int],
                light: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: makes of its `light` that of all frames, and counts these; all (pixel,).

    remembers: whether there is a last frame, which knew past_light of past_frames.
    """
    pixel = first + wp.tid()
    frames[pixel] = 0
    if gbuffer.face[pixel] == NO_HIT:
        return
    known = int(0)
    most = most_frames(gbuffer, pixel)
    if remembers:
        place = previous_place(past, gbuffer.position[pixel], width, height)
        total = float(0.0)
        number = float(0.0)
        mean = wp.vec3(0.0, 0.0, 0.0)
        for corner in range(4):
            found = bilinear_tap(past, past_frames, gbuffer, pixel, place, corner, 1, width, height)
            if found.share > 0.0:
                total += found.share
                number += found.share * float(past_frames[found.pixel])
                mean += past_light[found.pixel] * found.share
        # What is not finite is of its frame alone, which counts it.
        if total >= LEAST_SHARE and wp.isfinite(mean):
            known = int(number + 0.5)
            light[pixel] = blend(light[pixel], mean / total, known, most)
    frames[pixel] = wp.min(known + 1, most)


class DirectHistory:
    """What frames of a viewer's walk of `size` (width, height) found of soft light; arrays are allocated once."""

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device, self._size = device, size
        self.frames = wp.zeros(size[0] * size[1], dtype=int, device=device)
        self._allocate_past()

    def for_another_viewer(self) -> "DirectHistory":
        """One with light of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other._allocate_past()
        return other

    def _allocate_past(self) -> None:
        self._past_frames = wp.zeros(len(self.frames), dtype=int, device=self.device)
        self._past_light = wp.zeros(len(self.frames), dtype=wp.vec3, device=self.device)

    def take(self, gbuffer: GBuffer, last: PreviousFrame, light: wp.array, *, remembers: bool) -> None:
        """Make of the soft `light` (pixel,) that this frame's rays found that of all frames' rays, and keep it.

        remembers: whether there is a `last` frame that this one may build on.
        """
        inputs = [gbuffer, last.data, remembers, *self._size, self._past_frames, self._past_light, self.frames, light]
        launch(take_kernel, len(light), inputs, self.device)
        wp.copy(self._past_frames, self.frames)
        wp.copy(self._past_light, light)

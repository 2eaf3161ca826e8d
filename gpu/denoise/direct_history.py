"""Direct light of area lights in a walk: the mean of what its frames found where they saw the same surface.

A pixel has one or two shadow rays a frame. Where a lamp is seen by few of them, or a penumbra is wide, that leaves dots
and ragged edges which no smoothing of a single frame removes. gpu.denoise.reprojection finds the surface.
"""

from copy import copy

import warp as wp

from gpu.core.device import allocate, launch
from gpu.denoise.reprojection import (
    REPROJECTION_PARAMETERS,
    PreviousFrame,
    PreviousFrameData,
    ReprojectionParameters,
    bilinear_tap,
    blend,
    previous_place,
)
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer


@wp.struct
class DirectHistoryData:
    """Light of area lights, (pixel,) each: frames: how many it is the mean of, 0 where there is no surface; light."""

    frames: wp.array[int]
    light: wp.array[wp.vec3]


@wp.func
def max_direct_frames(gbuffer: GBuffer, pixel: int, chosen: ReprojectionParameters) -> int:
    """How many frames the light of a pixel may be the mean of."""
    if wp.max(gbuffer.f0[pixel]) == 0.0:
        return chosen.max_frames
    return wp.clamp(int(chosen.frames_per_roughness * gbuffer.roughness[pixel]), 1, chosen.max_frames)


@wp.kernel
def blend_direct_kernel(first: int, gbuffer: GBuffer, previous: PreviousFrameData, known: DirectHistoryData,
                        reads: bool, chosen: ReprojectionParameters, now: DirectHistoryData) -> None:  # fmt: skip
    """One thread a pixel: makes of its light `now` that of all frames, and counts these.

    reads: whether there is a previous frame, which left what is `known`.
    """
    pixel = first + wp.tid()
    now.frames[pixel] = 0
    if gbuffer.face[pixel] == NO_HIT:
        return
    frames = int(0)
    most = max_direct_frames(gbuffer, pixel, chosen)
    if reads:
        place = previous_place(previous, gbuffer, pixel)
        total = float(0.0)
        number = float(0.0)
        mean = wp.vec3(0.0, 0.0, 0.0)
        for corner in range(4):
            tap = bilinear_tap(previous, known.frames, gbuffer, pixel, place, corner, 1, chosen.plane_tolerance)
            if tap.share > 0.0:
                total += tap.share
                number += tap.share * float(known.frames[tap.pixel])
                mean += known.light[tap.pixel] * tap.share
        # What is not finite is of its frame alone, which counts it.
        if total >= chosen.min_share and wp.isfinite(mean):
            frames = int(number + 0.5)
            now.light[pixel] = blend(now.light[pixel], mean / total, frames, most)
    now.frames[pixel] = wp.min(frames + 1, most)


@wp.kernel
def keep_direct_kernel(first: int, now: DirectHistoryData, out: DirectHistoryData) -> None:
    """One thread a pixel: keeps what is known `now`."""
    pixel = first + wp.tid()
    out.frames[pixel] = now.frames[pixel]
    out.light[pixel] = now.light[pixel]


@wp.kernel
def known_frames_kernel(first: int, gbuffer: GBuffer, previous: PreviousFrameData, known: wp.array[int],
                        chosen: ReprojectionParameters, frames: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel: of how many `frames` the light is that the pixel of the last frame next to its SP has.

    known (pixel,): those of the last frame's pixels.
    """
    pixel = first + wp.tid()
    frames[pixel] = 0
    if gbuffer.face[pixel] == NO_HIT:
        return
    place = previous_place(previous, gbuffer, pixel)
    nearest = wp.vec2(wp.round(place[0]), wp.round(place[1]))
    tap = bilinear_tap(previous, known, gbuffer, pixel, nearest, 0, 1, chosen.plane_tolerance)
    if tap.share > 0.0:
        frames[pixel] = known[tap.pixel]


class DirectHistory:
    """What frames of a viewer's walk of `size` (width, height) found of area lights; arrays are allocated once.

    frames (pixel,): how many the light of the frame at hand is the mean of.
    """

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.frames = wp.zeros(size[0] * size[1], dtype=int, device=device)
        self._known: DirectHistoryData = allocate(DirectHistoryData, len(self.frames), device)

    def for_another_viewer(self) -> "DirectHistory":
        """One with light of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other._known = allocate(DirectHistoryData, len(self.frames), self.frames.device)
        return other

    def find(self, gbuffer: GBuffer, previous: PreviousFrame) -> wp.array:
        """Of how many frames light is known before this one's rays, (pixel,), up to the next `take`."""
        inputs = [gbuffer, previous.data, self._known.frames, REPROJECTION_PARAMETERS, self.frames]
        launch(known_frames_kernel, len(self.frames), inputs, self.frames.device)
        return self.frames

    def take(self, gbuffer: GBuffer, previous: PreviousFrame, light: wp.array, *, read_history: bool) -> None:
        """Make of the `light` (pixel,) that this frame's rays found that of all frames' rays, and keep it.

        read_history: whether there is a `previous` frame that this one may build on.
        """
        now = DirectHistoryData()
        now.frames, now.light = self.frames, light
        inputs = [gbuffer, previous.data, self._known, read_history, REPROJECTION_PARAMETERS, now]
        launch(blend_direct_kernel, len(light), inputs, self.frames.device)
        launch(keep_direct_kernel, len(light), [now, self._known], self.frames.device)

"""Irradiance that the rays of a walk's earlier frames found, where this frame sees the same surfaces
(gpu.denoise.reprojection).
"""

from copy import copy

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import allocate, launch
from gpu.core.image_size import image_of
from gpu.denoise.reprojection import (
    LEAST_SHARE,
    MOST_FRAMES,
    PreviousFrame,
    PreviousFrameData,
    bilinear_tap,
    blend,
    previous_place,
)
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import is_anchor_only

# Of SPs whose light is that of so many frames, on even surfaces, one run in so many sends rays: each run's rays are
# those that a GPU runs together. Elsewhere neighbours tell too little of what a frame more may find.
SETTLED_FRAMES, RAY_PERIOD = wp.constant(5), wp.constant(3)
WARP_GROUP = wp.constant(8)
# Around them it may differ so many times: at contacts light that is handed on fills the dark, which only rays find.
EVEN_LIGHT = wp.constant(1.5)


@wp.struct
class IndirectHistoryData:
    """What a frame knew of its SPs, as the next one finds it. (pixel,) each.

    frames: how many the light is the mean of, 0 where there is no SP; light, near: irradiance by VPLs, and what these
    lack of it near field [W/m²].
    """

    frames: wp.array[int]
    light: wp.array[wp.vec3]
    near: wp.array[wp.vec3]


@wp.kernel
def find_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], count: wp.array[int], listed: wp.array[int],
                past: PreviousFrameData, width: int, height: int, stride: int, known: IndirectHistoryData, seed:
                wp.array[int], frames: wp.array[int], settled: wp.array[int], light: wp.array[wp.vec3],
                near: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: what the last frame knew of its place, and whether that will do in this one. seed: (1,).

    That is between the four pixels about it if these had SPs, else between the four anchors
    (gpu.gbuffer.sparse_shading). frames, settled, light, near (pixel,).
    """
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = sps[sp]
    frames[pixel] = 0
    settled[pixel] = 0
    place = previous_place(past, gbuffer.position[pixel], width, height)
    even = is_anchor_only(listed, pixel, image_of(width, height))
    for attempt in range(2):
        step = wp.where((attempt == 0) == even, stride, 1)
        total = float(0.0)
        number = float(0.0)
        mean = wp.vec3(0.0, 0.0, 0.0)
        near_mean = wp.vec3(0.0, 0.0, 0.0)
        least = float(FAR_AWAY)
        most = float(0.0)
        for corner in range(4):
            found = bilinear_tap(past, known.frames, gbuffer, pixel, place, corner, step, width, height)
            if found.share > 0.0:
                total += found.share
                number += found.share * float(known.frames[found.pixel])
                mean += known.light[found.pixel] * found.share
                near_mean += known.near[found.pixel] * found.share
                bright = brightness(known.light[found.pixel])
                least = wp.min(least, bright)
                most = wp.max(most, bright)
        # What is not finite is of its frame alone, which counts it.
        if total >= LEAST_SHARE and wp.isfinite(mean) and wp.isfinite(near_mean):
            frames[pixel] = int(number + 0.5)
            rests = frames[pixel] >= SETTLED_FRAMES and (sp // WARP_GROUP + seed[0]) % RAY_PERIOD != 0
            if rests and even and most <= EVEN_LIGHT * least:
                settled[pixel] = 1
            light[pixel] = mean / total
            near[pixel] = near_mean / total
            return


@wp.kernel
def light_kernel(first: int, sps: wp.array[int], count: wp.array[int], frames: wp.array[int], settled: wp.array[int],
                 irradiance: wp.array[wp.vec3], own: wp.array[wp.vec3], light: wp.array[wp.vec3],
                 lacking: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: takes what its own rays make of its irradiance into `light`; what irradiance lacks of that.

    All (pixel,). lacking: `own` itself where no frame before saw the SP; `own` becomes that where it is settled.
    """
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = sps[sp]
    if settled[pixel] == 1:
        own[pixel] = light[pixel] - irradiance[pixel]
        lacking[pixel] = own[pixel]
        return
    mean = blend(irradiance[pixel] + own[pixel], light[pixel], frames[pixel], MOST_FRAMES)
    light[pixel] = mean
    lacking[pixel] = wp.where(frames[pixel] > 0, mean - irradiance[pixel], own[pixel])


@wp.kernel
def near_kernel(first: int, sps: wp.array[int], count: wp.array[int], frames: wp.array[int],
                found: wp.array[wp.vec3], near: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: takes the near-field light that its ray `found` into `near`, and makes it that mean."""
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = sps[sp]
    near[pixel] = blend(found[pixel], near[pixel], frames[pixel], MOST_FRAMES)
    found[pixel] = near[pixel]


@wp.kernel
def keep_kernel(first: int, listed: wp.array[int], frames: wp.array[int], light: wp.array[wp.vec3],
                near: wp.array[wp.vec3], to: IndirectHistoryData, known: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel: keeps what this frame knows of its SP, if it has one: listed (pixel,) is 1 there.

    known (pixel,): 1 where frames before knew it, too, else 0.
    """
    pixel = first + wp.tid()
    to.frames[pixel] = 0
    known[pixel] = 0
    if listed[pixel] == 1:
        known[pixel] = wp.min(frames[pixel], 1)
        to.frames[pixel] = wp.min(frames[pixel] + 1, MOST_FRAMES)
        to.light[pixel] = light[pixel]
        to.near[pixel] = near[pixel]


class IndirectHistory:
    """What frames of a viewer's walk of `size` (width, height) found; its arrays are allocated once.

    frames (pixel,): how many earlier frames each of the SPs has its light of; settled (pixel,): 1 where this is so well
    known that the SP sends no rays to correct it by, else 0; known (pixel,): once it is kept, 1 where frames are any, 0
    for other pixels. A frame either finds its SPs in the one before or forgets that, then takes in what its rays find,
    and keeps all that for the next one.
    """

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device, self._size = device, size
        pixels = size[0] * size[1]
        self.frames = wp.zeros(pixels, dtype=int, device=device)
        self.settled = wp.zeros(pixels, dtype=int, device=device)
        self.known = wp.zeros(pixels, dtype=int, device=device)
        self.light = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._near = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._lacking = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._past: IndirectHistoryData = allocate(IndirectHistoryData, pixels, device)

    def for_another_viewer(self) -> "IndirectHistory":
        """One with light of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other._past = allocate(IndirectHistoryData, len(self.frames), self.device)
        return other

    def forget(self) -> None:
        """Build on no frame before."""
        self.frames.zero_()
        self.settled.zero_()

    def find(self, gbuffer: GBuffer, sps: ShadingPoints, last: PreviousFrame, seed: wp.array) -> None:
        """Find this frame's `sps` in the `last` one; seed: (1,), this frame's."""
        inputs = [gbuffer, sps.pixels, sps.count, sps.listed, last.data, *self._size, sps.stride, self._past, seed]
        launch(find_kernel, sps.capacity, [*inputs, self.frames, self.settled, self.light, self._near], self.device)

    def take_light(self, sps: ShadingPoints, irradiance: wp.array, own: wp.array) -> wp.array:
        """What `irradiance` lacks by the rays of all frames, where by this frame's it lacks `own`; (pixel,) each."""
        inputs = [sps.pixels, sps.count, self.frames, self.settled, irradiance, own, self.light, self._lacking]
        launch(light_kernel, sps.capacity, inputs, self.device)
        return self._lacking

    def take_near(self, sps: ShadingPoints, light: wp.array) -> None:
        """Make of the near-field `light` (pixel,) that this frame's rays found that of all frames' rays."""
        inputs = [sps.pixels, sps.count, self.frames, light, self._near]
        launch(near_kernel, sps.capacity, inputs, self.device)

    def keep(self, sps: ShadingPoints) -> None:
        """Keep what is known of `sps` for the next frame."""
        inputs = [sps.listed, self.frames, self.light, self._near, self._past, self.known]
        launch(keep_kernel, sps.capacity, inputs, self.device)

"""Irradiance that the rays of a walk's earlier frames found, where this frame sees the same surfaces.

gpu.denoise.reprojection finds these.
"""

from copy import copy

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
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
from gpu.denoise.sparse_image import SparseImage, sparse_image
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import is_anchor_only

# SPs whose rays a GPU runs together, so that all of them send rays or none.
WARP_GROUP = wp.constant(8)


@wp.struct
class IndirectHistoryData:
    """What a frame knew of its SPs, as the next one finds it, (pixel,) each.

    frames: how many the light is the mean of, 0 where there is no SP; light, near: irradiance by VPLs, and what these
    lack of it near field [W/m²].
    """

    frames: wp.array[int]
    light: wp.array[wp.vec3]
    near: wp.array[wp.vec3]


@wp.struct
class IndirectLight:
    """What a frame knows of its SPs, (pixel,) each.

    frames, light, near: as in IndirectHistoryData, at first of the frames before; settled: 1 where that will do.
    """

    frames: wp.array[int]
    settled: wp.array[int]
    light: wp.array[wp.vec3]
    near: wp.array[wp.vec3]


@wp.kernel
def find_indirect_kernel(first: int, gbuffer: GBuffer, points: PointList, sparse: SparseImage,
                         previous: PreviousFrameData, known: IndirectHistoryData, seed: wp.array[int],
                         chosen: ReprojectionParameters, now: IndirectLight) -> None:  # fmt: skip
    """One thread an SP: what the last frame knew of its place, and whether that will do in this one. seed: (1,).

    That is between the four pixels about it if these had SPs, else between the four anchors
    (gpu.gbuffer.sparse_shading).
    """
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    now.frames[pixel] = 0
    now.settled[pixel] = 0
    place = previous_place(previous, gbuffer, pixel)
    even = is_anchor_only(sparse.listed, pixel, sparse.image)
    for attempt in range(2):
        step = wp.where((attempt == 0) == even, sparse.stride, 1)
        total = float(0.0)
        number = float(0.0)
        mean = wp.vec3(0.0, 0.0, 0.0)
        near_mean = wp.vec3(0.0, 0.0, 0.0)
        least = float(FAR_AWAY)
        most = float(0.0)
        for corner in range(4):
            tap = bilinear_tap(previous, known.frames, gbuffer, pixel, place, corner, step, chosen.plane_tolerance)
            if tap.share > 0.0:
                total += tap.share
                number += tap.share * float(known.frames[tap.pixel])
                mean += known.light[tap.pixel] * tap.share
                near_mean += known.near[tap.pixel] * tap.share
                bright = brightness(known.light[tap.pixel])
                least = wp.min(least, bright)
                most = wp.max(most, bright)
        # What is not finite is of its frame alone, which counts it.
        if total >= chosen.min_share and wp.isfinite(mean) and wp.isfinite(near_mean):
            frames = int(number + 0.5)
            rests = frames >= chosen.settled_frames and (sp // WARP_GROUP + seed[0]) % chosen.ray_period != 0
            now.frames[pixel] = frames
            # Elsewhere neighbours tell too little of what a frame more may find.
            if rests and even and most <= chosen.even_light * least:
                now.settled[pixel] = 1
            now.light[pixel] = mean / total
            now.near[pixel] = near_mean / total
            return


@wp.kernel
def blend_indirect_kernel(first: int, points: PointList, irradiance: wp.array[wp.vec3], correction: wp.array[wp.vec3],
                          max_frames: int, now: IndirectLight, residual: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: takes what its own rays make of its irradiance into its light; what irradiance lacks of that.

    All (pixel,). residual: the `correction` by its own rays where no frame before saw the SP; correction: becomes the
    residual where that is settled.
    """
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    if now.settled[pixel] == 1:
        correction[pixel] = now.light[pixel] - irradiance[pixel]
        residual[pixel] = correction[pixel]
        return
    mean = blend(irradiance[pixel] + correction[pixel], now.light[pixel], now.frames[pixel], max_frames)
    now.light[pixel] = mean
    residual[pixel] = wp.where(now.frames[pixel] > 0, mean - irradiance[pixel], correction[pixel])


@wp.kernel
def blend_near_kernel(first: int, points: PointList, found: wp.array[wp.vec3], max_frames: int,
                      now: IndirectLight) -> None:  # fmt: skip
    """One thread an SP: takes the near-field light (pixel,) that its ray `found` into `near`; it becomes that mean."""
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    now.near[pixel] = blend(found[pixel], now.near[pixel], now.frames[pixel], max_frames)
    found[pixel] = now.near[pixel]


@wp.kernel
def keep_indirect_kernel(first: int, listed: wp.array[int], now: IndirectLight, max_frames: int,
                         out: IndirectHistoryData, known: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel: keeps what this frame knows of its SP, if it has one: listed (pixel,) is 1 there.

    known (pixel,): 1 where frames before knew it, too, else 0.
    """
    pixel = first + wp.tid()
    out.frames[pixel] = 0
    known[pixel] = 0
    if listed[pixel] == 1:
        known[pixel] = wp.min(now.frames[pixel], 1)
        out.frames[pixel] = wp.min(now.frames[pixel] + 1, max_frames)
        out.light[pixel] = now.light[pixel]
        out.near[pixel] = now.near[pixel]


class IndirectHistory:
    """What frames of a viewer's walk of `size` (width, height) found; its arrays are allocated once.

    frames (pixel,): how many earlier frames each of the SPs has its light of; settled (pixel,): 1 where this is so well
    known that the SP sends no rays to correct it by, else 0; light (pixel,): that; known (pixel,): once it is kept, 1
    where frames are any, 0 for other pixels. A frame either finds its SPs in the one before or forgets that, then takes
    in what its rays find, and keeps all that for the next one.
    """

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device, self._size = device, size
        pixels = size[0] * size[1]
        self._now: IndirectLight = allocate(IndirectLight, pixels, device)
        self.frames, self.settled, self.light = self._now.frames, self._now.settled, self._now.light
        self.known = wp.zeros(pixels, dtype=int, device=device)
        self._residual = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._kept: IndirectHistoryData = allocate(IndirectHistoryData, pixels, device)

    def for_another_viewer(self) -> "IndirectHistory":
        """One with light of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other._kept = allocate(IndirectHistoryData, len(self.frames), self.device)
        return other

    def forget(self) -> None:
        """Build on no frame before."""
        self.frames.zero_()
        self.settled.zero_()

    def find(self, gbuffer: GBuffer, sps: ShadingPoints, previous: PreviousFrame, seed: wp.array) -> None:
        """Find this frame's `sps` in the `previous` one; seed: (1,), this frame's."""
        sparse = sparse_image(self._size, sps)
        inputs = [gbuffer, sps.points, sparse, previous.data, self._kept, seed, REPROJECTION_PARAMETERS, self._now]
        launch(find_indirect_kernel, sps.capacity, inputs, self.device)

    def take_light(self, sps: ShadingPoints, irradiance: wp.array, correction: wp.array) -> wp.array:
        """What `irradiance` lacks by the rays of all frames, by this frame's `correction`; (pixel,) each."""
        inputs = [sps.points, irradiance, correction, REPROJECTION_PARAMETERS.max_frames, self._now, self._residual]
        launch(blend_indirect_kernel, sps.capacity, inputs, self.device)
        return self._residual

    def take_near(self, sps: ShadingPoints, light: wp.array) -> None:
        """Make of the near-field `light` (pixel,) that this frame's rays found that of all frames' rays."""
        inputs = [sps.points, light, REPROJECTION_PARAMETERS.max_frames, self._now]
        launch(blend_near_kernel, sps.capacity, inputs, self.device)

    def keep(self, sps: ShadingPoints) -> None:
        """Keep what is known of `sps` for the next frame."""
        inputs = [sps.listed, self._now, REPROJECTION_PARAMETERS.max_frames, self._kept, self.known]
        launch(keep_indirect_kernel, sps.capacity, inputs, self.device)

"""Irradiance that the rays of a walk's earlier frames found, taken to where this frame sees the same surfaces.

Irradiance belongs to a surface, not to a view, and stays true while the lights do. So what a frame's few rays find goes
into a mean with those of the frames before, looked up where their camera saw the same point: reverse reprojection (D.
Nehab et al., Accelerating Real-Time Shading with Reverse Reprojection Caching, 2007), the temporal part of C. Schied et
al. 2017. Beyond the 2022 paper, which leaves temporal coherence to future work.
"""

import warp as wp

from gpu.device import allocate, launch
from gpu.gbuffer import CameraData, GBuffer, image_point
from gpu.kinship import likeness
from gpu.shading_points import ShadingPoints

# A mean of so many frames, from which on older ones fade out, has little noise; each frame that hands it on blurs it a
# little.
MOST_FRAMES = wp.constant(8)
# Of what surrounds a point in the frame before, the least share that must be of its surface. At edges the rest is not,
# and light comes from farther inside: frames count by that share, so that these forget sooner.
LEAST_SHARE = wp.constant(0.5)
# How far off its plane a point is still of a surface, in spacings a step: slats and cracks are as deep as a pixel.
PLANE_TOLERANCE = wp.constant(0.2)


@wp.struct
class Past:
    """What a frame knew of its SPs, as the next one finds it. (pixel,) each.

    frames: how many the light is the mean of, 0 where there is no SP; position, normal: of the SP in unit space; light,
    near: irradiance by VPLs, and what these lack of it near field [W/m²].
    """

    frames: wp.array[int]
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    light: wp.array[wp.vec3]
    near: wp.array[wp.vec3]


@wp.kernel
def find_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], count: wp.array[int], cameras: wp.array[CameraData],
                width: int, height: int, stride: int, past: Past, frames: wp.array[int], light: wp.array[wp.vec3],
                near: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: what the last frame, seen by cameras[0], knew of its place. frames, light, near (pixel,).

    That is between the four pixels about it if these had SPs, else between the four anchors (gpu.interpolate).
    """
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = sps[sp]
    frames[pixel] = 0
    position = gbuffer.position[pixel]
    normal = gbuffer.normal[pixel]
    geometric = gbuffer.geometric[pixel]
    limit = PLANE_TOLERANCE * gbuffer.spacing[pixel]
    place = image_point(cameras[0], position, width, height)
    for attempt in range(2):
        step = wp.where(attempt == 0, 1, stride)
        x = place[0] / float(step)
        y = place[1] / float(step)
        total = float(0.0)
        number = float(0.0)
        mean = wp.vec3(0.0, 0.0, 0.0)
        near_mean = wp.vec3(0.0, 0.0, 0.0)
        for corner in range(4):
            column = int(wp.floor(x)) + corner % 2
            row = int(wp.floor(y)) + corner // 2
            share = (1.0 - wp.abs(x - float(column))) * (1.0 - wp.abs(y - float(row)))
            column *= step
            row *= step
            if column >= 0 and column < width and row >= 0 and row < height:
                other = row * width + column
                if past.frames[other] > 0:
                    way = past.position[other] - position
                    share *= likeness(normal, geometric, way, past.normal[other], limit * float(step))
                    total += share
                    number += share * float(past.frames[other])
                    mean += past.light[other] * share
                    near_mean += past.near[other] * share
        if total >= LEAST_SHARE:
            frames[pixel] = int(number + 0.5)
            light[pixel] = mean / total
            near[pixel] = near_mean / total
            return


@wp.func
def joined(value: wp.vec3, mean: wp.vec3, frames: int) -> wp.vec3:
    """The mean of `frames` frames with one more, of MOST_FRAMES about."""
    if frames == 0:
        return value
    return mean + (value - mean) / float(wp.min(frames + 1, MOST_FRAMES))


@wp.kernel
def light_kernel(first: int, sps: wp.array[int], count: wp.array[int], frames: wp.array[int],
                 irradiance: wp.array[wp.vec3], own: wp.array[wp.vec3], light: wp.array[wp.vec3],
                 lacking: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: takes what its own rays make of its irradiance into `light`; what irradiance lacks of that.

    All (pixel,). lacking: `own` itself where no frame before saw the SP.
    """
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = sps[sp]
    mean = joined(irradiance[pixel] + own[pixel], light[pixel], frames[pixel])
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
    near[pixel] = joined(found[pixel], near[pixel], frames[pixel])
    found[pixel] = near[pixel]


@wp.kernel
def keep_kernel(first: int, gbuffer: GBuffer, listed: wp.array[int], frames: wp.array[int], light: wp.array[wp.vec3],
                near: wp.array[wp.vec3], past: Past, known: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel: keeps what this frame knows of its SP, if it has one: listed (pixel,) is 1 there.

    known (pixel,): 1 where frames before knew it, too, else 0.
    """
    pixel = first + wp.tid()
    past.frames[pixel] = 0
    known[pixel] = 0
    if listed[pixel] == 1:
        known[pixel] = wp.min(frames[pixel], 1)
        past.frames[pixel] = wp.min(frames[pixel] + 1, MOST_FRAMES)
        past.position[pixel] = gbuffer.position[pixel]
        past.normal[pixel] = gbuffer.normal[pixel]
        past.light[pixel] = light[pixel]
        past.near[pixel] = near[pixel]


class History:
    """What a walk's frames of `size` (width, height) found; its arrays are allocated once.

    frames (pixel,): how many earlier frames each of the SPs has its light of; known (pixel,): once it is kept, 1 where
    these are any, 0 for other pixels. A frame either finds its SPs in the one before or forgets that, then takes in
    what its rays find, and keeps all that for the next one.
    """

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device, self._size = device, size
        pixels = size[0] * size[1]
        self.frames = wp.zeros(pixels, dtype=int, device=device)
        self.known = wp.zeros(pixels, dtype=int, device=device)
        self._light = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._near = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._lacking = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._camera = wp.zeros(1, dtype=CameraData, device=device)
        self._past: Past = allocate(Past, pixels, device)

    def forget(self) -> None:
        """Build on no frame before."""
        self.frames.zero_()

    def find(self, gbuffer: GBuffer, sps: ShadingPoints) -> None:
        """Find this frame's `sps` in the last one."""
        inputs = [gbuffer, sps.pixels, sps.count, self._camera, *self._size, sps.stride, self._past]
        launch(find_kernel, sps.capacity, [*inputs, self.frames, self._light, self._near], self.device)

    def take_light(self, sps: ShadingPoints, irradiance: wp.array, own: wp.array) -> wp.array:
        """What `irradiance` lacks by the rays of all frames, where by this frame's it lacks `own`; (pixel,) each."""
        inputs = [sps.pixels, sps.count, self.frames, irradiance, own, self._light, self._lacking]
        launch(light_kernel, sps.capacity, inputs, self.device)
        return self._lacking

    def take_near(self, sps: ShadingPoints, light: wp.array) -> None:
        """Make of the near-field `light` (pixel,) that this frame's rays found that of all frames' rays."""
        inputs = [sps.pixels, sps.count, self.frames, light, self._near]
        launch(near_kernel, sps.capacity, inputs, self.device)

    def keep(self, gbuffer: GBuffer, sps: ShadingPoints, camera: wp.array) -> None:
        """Keep what is known of `sps` for the next frame; camera: (1,) CameraData that this one was seen by."""
        inputs = [gbuffer, sps.listed, self.frames, self._light, self._near, self._past, self.known]
        launch(keep_kernel, sps.capacity, inputs, self.device)
        wp.copy(self._camera, camera)

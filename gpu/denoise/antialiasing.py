"""Temporal anti-aliasing: each frame of a walk looks through another place in the pixels, and pictures are averaged.

The picture before is looked up where it showed the same surface (gpu.denoise.reprojection) and bounded by what this
frame has around (B. Karis, High-Quality Temporal Supersampling, 2014; M. Salvi, An Excursion in Temporal Supersampling,
2016; survey: L. Yang et al., A Survey of Temporal Antialiasing Techniques, 2020), the less the more alike all of that
moves: no frame builds on one of before an edit, so that only what a camera uncovers can be wrong. Each look-up between
pixels brings a little of what is bright over an edge. Beside what is hundreds of times brighter that shows more than
stairs do, for the mean of such an edge looks as bright as its bright side: means are of few frames there, all alike on
both sides, so that no light is lost. A pixel takes 200 bytes of memory traffic, 56 of them to copy what was made.
"""

from copy import copy
from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness, from_ycocg, to_ycocg
from gpu.core.constants import FAR_AWAY, GOLDEN_RATIO
from gpu.core.device import allocate, launch
from gpu.core.image_size import ImageSize
from gpu.core.parameters import parameters
from gpu.core.sample_mean import SAMPLES, find_sample_mean
from gpu.core.stencil import nearest_beside
from gpu.denoise.reprojection import PreviousFrame, PreviousFrameData, bilinear_tap
from gpu.device_scene.bsdf import BSDF_PARAMETERS
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, image_point, pixel_ray
from gpu.gbuffer.gbuffer import GBuffer, apparent_position

# The sky is so far away, in unit space, that it hardly moves as the camera does.
SKY_DISTANCE = wp.constant(100.0)


@wp.struct
@dataclass
class AntialiasingParameters:
    """How pictures are averaged.

    max_frames: a mean of so many, from which on older ones fade out: more blur what moves, and edges gain little.
    min_share: of what surrounds a point in the last frame, so much must be of its surface; little, for at edges that
    saw other surfaces in the same pixels. plane_tolerance: how far off its plane a point is of a surface, in spacings.
    deviations: of this frame's colours around a pixel, which earlier ones may differ from their mean by: what is left
    of things that have moved on is cut off. slip: between what is in front around a pixel and what is behind, from one
    frame to the next [pixels]; where it is less, as many times more deviations are let through: where all moves alike,
    earlier pictures are right, and thin bright things that this frame missed would be cut off, too.
    soft_contrast, stark_contrast: of the brightest around a pixel to the darkest: up to the one a mean is of
    max_frames, from the other on it is this frame alone. dark: times the picture's mean; what is darker counts as that,
    for little of it shows.
    """

    max_frames: int = 8
    min_share: float = 0.05
    plane_tolerance: float = 2.0
    deviations: float = 1.0
    slip: float = 0.25
    soft_contrast: float = 5.0
    stark_contrast: float = 200.0
    dark: float = 0.1


ANTIALIASING_PARAMETERS: AntialiasingParameters = parameters(AntialiasingParameters)


@wp.struct
class PictureData:
    """A mean of pictures, (pixel,) each.

    frames: how many it is of, below zero where there is no surface, 0 where there was no picture; radiance [W/m²/sr];
    brightness (1,): about the mean of the last picture's.
    """

    frames: wp.array[int]
    radiance: wp.array[wp.vec3]
    brightness: wp.array[float]


def new_pictures(pixels: int, device: wp.Device) -> PictureData:
    """Of none yet, for so many pixels."""
    pictures = PictureData()
    pictures.frames = wp.zeros(pixels, dtype=int, device=device)
    pictures.radiance = wp.zeros(pixels, dtype=wp.vec3, device=device)
    pictures.brightness = wp.zeros(1, dtype=float, device=device)
    return pictures


@wp.func
def pixels_between(pixel: int, other: int, image: ImageSize) -> wp.vec2:
    """How far another pixel is to the right of one and below it [pixels]."""
    right = other % image.width - pixel % image.width
    return wp.vec2(float(right), float(other // image.width - pixel // image.width))


@wp.struct
class DepthExtrema:
    """Of the 3×3 pixels about one those whose surfaces are nearest to the camera and farthest from it."""

    nearest: int
    farthest: int


@wp.func
def depth_extrema(gbuffer: GBuffer, pixel: int, image: ImageSize) -> DepthExtrema:
    """The pixels at both ends of what is around one; farthest of all is the sky."""
    depths = DepthExtrema()
    depths.nearest = pixel
    depths.farthest = pixel
    least = float(FAR_AWAY)
    most = float(0.0)
    for number in range(9):
        other = nearest_beside(pixel, number, image)
        depth = wp.where(gbuffer.face[other] == NO_HIT, float(FAR_AWAY), gbuffer.spacing[other])
        if depth < least:
            least = depth
            depths.nearest = other
        if depth > most:
            most = depth
            depths.farthest = other
    return depths


@wp.func
def reprojected(gbuffer: GBuffer, camera: CameraData, before: CameraData, pixel: int, image: ImageSize) -> wp.vec2:
    """Where the camera of the frame before saw what `pixel` shows [pixels], as gpu.gbuffer.camera_rays.image_point."""
    if gbuffer.face[pixel] != NO_HIT:
        return image_point(before, apparent_position(gbuffer, pixel), image)
    ray = pixel_ray(camera, pixel, image)
    return image_point(before, ray.origin + ray.direction * SKY_DISTANCE, image)


@wp.func
def depends_on_view(gbuffer: GBuffer, pixel: int) -> bool:
    """Whether what a pixel shows changes as the camera moves: in narrow lobes, mirrors and glass."""
    if gbuffer.face[pixel] == NO_HIT:
        return False
    if wp.length(apparent_position(gbuffer, pixel) - gbuffer.position[pixel]) > gbuffer.spacing[pixel]:
        return True
    if gbuffer.gloss:
        narrow = gbuffer.roughness[pixel] < wp.static(BSDF_PARAMETERS.glossy_roughness)
        return gbuffer.f90[pixel] > 0.0 and narrow
    return False


@wp.func
def frames_before(previous: PreviousFrameData, frames: wp.array[int], gbuffer: GBuffer, pixel: int, place: wp.vec2,
                  chosen: AntialiasingParameters) -> int:  # fmt: skip
    """Of how many frames the picture is around the `place` of what `pixel` shows in the last frame; 0: it was not seen.

    frames (pixel,): as PictureData has them.
    """
    total = float(0.0)
    number = float(0.0)
    for corner in range(4):
        if gbuffer.face[pixel] != NO_HIT:
            tap = bilinear_tap(previous, frames, gbuffer, pixel, place, corner, 1, chosen.plane_tolerance)
            total += tap.share
            number += tap.share * float(frames[tap.pixel])
        else:
            column = wp.clamp(int(wp.floor(place[0])) + corner % 2, 0, previous.image.width - 1)
            row = wp.clamp(int(wp.floor(place[1])) + corner // 2, 0, previous.image.height - 1)
            count = frames[row * previous.image.width + column]
            if count < 0:
                total += 0.25
                number -= 0.25 * float(count)
    if total < chosen.min_share:
        return 0
    return int(number / total + 0.5)


@wp.func
def catmull_rom_weight(distance: float) -> float:
    """Of a value so far away, by E. Catmull and R. Rom's spline: it keeps sharp what is looked up again and again."""
    x = wp.abs(distance)
    if x < 1.0:
        return (1.5 * x - 2.5) * x * x + 1.0
    if x < 2.0:
        return ((2.5 - 0.5 * x) * x - 4.0) * x + 2.0
    return 0.0


@wp.func
def catmull_rom(picture: wp.array[wp.vec3], place: wp.vec2, image: ImageSize) -> wp.vec3:
    """A picture (pixel,) between its pixels, at a place [pixels], by a bicubic spline."""
    left = int(wp.floor(place[0])) - 1
    top = int(wp.floor(place[1])) - 1
    total = wp.vec3(0.0, 0.0, 0.0)
    for tap in range(16):
        column = left + tap % 4
        row = top + tap // 4
        weight = catmull_rom_weight(place[0] - float(column)) * catmull_rom_weight(place[1] - float(row))
        inside = wp.clamp(row, 0, image.height - 1) * image.width + wp.clamp(column, 0, image.width - 1)
        total += picture[inside] * weight
    return total


@wp.struct
class Neighbourhood:
    """3×3 pixels about one: mean and variance of luma and chroma, brightness of the darkest and of the brightest, and
    the least of each channel.
    """

    mean: wp.vec3
    variance: wp.vec3
    least: float
    most: float
    lower: wp.vec3


@wp.func
def neighbourhood(picture: wp.array[wp.vec3], pixel: int, image: ImageSize) -> Neighbourhood:
    """Of the 3×3 pixels about one of a picture (pixel,)."""
    around = Neighbourhood()
    around.least = FAR_AWAY
    around.lower = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
    mean = wp.vec3(0.0, 0.0, 0.0)
    square = wp.vec3(0.0, 0.0, 0.0)
    for number in range(9):
        colour = picture[nearest_beside(pixel, number, image)]
        around.least = wp.min(around.least, brightness(colour))
        around.most = wp.max(around.most, brightness(colour))
        around.lower = wp.min(around.lower, colour)
        beside = to_ycocg(colour)
        mean += beside / 9.0
        square += wp.cw_mul(beside, beside) / 9.0
    around.mean = mean
    around.variance = wp.max(square - wp.cw_mul(mean, mean), wp.vec3(0.0, 0.0, 0.0))
    return around


@wp.func
def variance_clipped(colour: wp.vec3, around: Neighbourhood, deviations: float) -> wp.vec3:
    """A colour moved towards the mean of what is `around` until it is so many deviations from that: variance clipping
    (Salvi 2016).

    No channel is below all around: beside a lamp deviations are large, and a spline of it and what is dark falls below
    zero, which would be a black rim.
    """
    mean, variance = around.mean, around.variance
    offset = to_ycocg(colour) - mean
    excess = float(1.0)
    for channel in range(3):
        most = deviations * wp.sqrt(variance[channel])
        excess = wp.max(excess, wp.abs(offset[channel]) / wp.max(most, 1.0e-12))
    return wp.max(from_ycocg(mean + offset / excess), around.lower)


@wp.func
def frames_across(around: Neighbourhood, picture_mean: float, chosen: AntialiasingParameters) -> float:
    """Of how many frames the mean is with so much contrast around: fewer the more, from `max_frames` to 1."""
    dark = wp.max(chosen.dark * picture_mean, 1.0e-12)
    contrast = wp.max(around.most, dark) / wp.max(around.least, dark)
    steps = wp.log(chosen.stark_contrast / chosen.soft_contrast)
    return wp.pow(float(chosen.max_frames), wp.clamp(wp.log(chosen.stark_contrast / contrast) / steps, 0.0, 1.0))


@wp.kernel
def sample_picture_kernel(first: int, radiance: wp.array[wp.vec3], samples: wp.array[float]) -> None:
    """One thread a sample: the brightness of one of SAMPLES pixels spread over a picture's `radiance` (pixel,)."""
    sample = first + wp.tid()
    count = radiance.shape[0]
    place = float(sample) * GOLDEN_RATIO
    pixel = wp.min(int((place - wp.floor(place)) * float(count)), count - 1)
    value = brightness(radiance[pixel])
    samples[sample] = wp.where(wp.isfinite(value), value, 0.0)


@wp.struct
class MotionData:
    """What is known of pixels' pictures before, (pixel,) each.

    place: where in the last frame's picture a pixel's was [pixels]; frames: of how many frames that is there, 0 where
    there is none; deviations: of this frame's colours around, which it may differ from their mean by.
    """

    place: wp.array[wp.vec2]
    frames: wp.array[int]
    deviations: wp.array[float]


@wp.kernel
def find_motion_kernel(first: int, gbuffer: GBuffer, camera: wp.array[CameraData], previous: PreviousFrameData,
                       known: PictureData, chosen: AntialiasingParameters, out: MotionData) -> None:  # fmt: skip
    """One thread a pixel: where its picture was. camera (1,): this frame's; known: pictures of those before."""
    pixel = first + wp.tid()
    image = previous.image
    out.frames[pixel] = 0
    # Silhouettes move as what is in front.
    depths = depth_extrema(gbuffer, pixel, image)
    shown = depths.nearest
    place = reprojected(gbuffer, camera[0], previous.camera[0], shown, image)
    if place[0] <= -1.0 or place[1] <= -1.0:
        return
    out.frames[pixel] = frames_before(previous, known.frames, gbuffer, shown, place, chosen)
    # Pictures are of whole pixels: what moves in them does so by as much, wherever in the pixels rays went through.
    moved = wp.vec2(previous.camera[0].x - camera[0].x, previous.camera[0].y - camera[0].y)
    out.place[pixel] = place + moved + pixels_between(shown, pixel, image)
    deviations = chosen.deviations
    if not depends_on_view(gbuffer, pixel):
        behind = reprojected(gbuffer, camera[0], previous.camera[0], depths.farthest, image)
        slip = wp.length(behind - place - pixels_between(shown, depths.farthest, image))
        deviations *= wp.max(chosen.slip / wp.max(slip, 1.0e-6), 1.0)
    out.deviations[pixel] = deviations


@wp.kernel
def antialias_kernel(first: int, face: wp.array[int], image: ImageSize, known: PictureData, motion: MotionData,
                     radiance: wp.array[wp.vec3], reads: bool, chosen: AntialiasingParameters,
                     now: PictureData) -> None:  # fmt: skip
    """One thread a pixel: the mean of this frame's `radiance` (pixel,) and of what is `known` from those before.

    face (pixel,): as GBuffer; reads: whether there is a previous frame. now: has its brightness already.
    """
    pixel = first + wp.tid()
    sign = wp.where(face[pixel] == NO_HIT, -1, 1)
    now.radiance[pixel] = radiance[pixel]
    now.frames[pixel] = sign
    if not reads:
        return
    frames = motion.frames[pixel]
    if frames == 0:
        return
    found = catmull_rom(known.radiance, motion.place[pixel], image)
    around = neighbourhood(radiance, pixel, image)
    before = variance_clipped(found, around, motion.deviations[pixel])
    # What is not finite is of its frame alone, which counts it.
    if wp.isfinite(before):
        most = wp.min(float(frames + 1), frames_across(around, now.brightness[0], chosen))
        now.radiance[pixel] = radiance[pixel] / most + before * (1.0 - 1.0 / most)
        now.frames[pixel] = sign * int(most + 0.5)


@wp.kernel
def keep_picture_kernel(first: int, now: PictureData, known: PictureData, radiance: wp.array[wp.vec3]) -> None:
    """One thread a pixel: has the mean picture in `radiance` (pixel,), and keeps it."""
    pixel = first + wp.tid()
    known.frames[pixel] = now.frames[pixel]
    known.radiance[pixel] = now.radiance[pixel]
    radiance[pixel] = now.radiance[pixel]


class PictureHistory:
    """The mean of the pictures of a viewer's walk, of `size` (width, height); its arrays are allocated once."""

    def __init__(self, size: tuple[int, int], device: wp.Device,
                 chosen: AntialiasingParameters = ANTIALIASING_PARAMETERS) -> None:  # fmt: skip
        self._chosen = chosen
        self._now = new_pictures(size[0] * size[1], device)
        self._known = new_pictures(size[0] * size[1], device)
        self._samples = wp.zeros(SAMPLES, dtype=float, device=device)
        self._motion: MotionData = allocate(MotionData, size[0] * size[1], device)

    def for_another_viewer(self) -> "PictureHistory":
        """One with pictures of its own; both share what a frame only works with, so they run one after the other."""
        other = copy(self)
        other._known = new_pictures(len(self._known.frames), self._known.frames.device)
        return other

    def take(self, gbuffer: GBuffer, camera: wp.array, previous: PreviousFrame, radiance: wp.array, *,
             read_history: bool) -> None:  # fmt: skip
        """Make of a frame's `radiance` (pixel,) the mean of all frames', and keep that; camera: (1,), the frame's.

        read_history: whether there is a `previous` frame that this one may build on.
        """
        launch(sample_picture_kernel, SAMPLES, [radiance, self._samples], radiance.device)
        find_sample_mean(self._samples, self._now.brightness)
        if read_history:
            looked = [gbuffer, camera, previous.data, self._known, self._chosen, self._motion]
            launch(find_motion_kernel, len(radiance), looked, radiance.device)
        pictures = [self._known, self._motion, radiance, read_history, self._chosen, self._now]
        launch(antialias_kernel, len(radiance), [gbuffer.face, previous.data.image, *pictures], radiance.device)
        launch(keep_picture_kernel, len(radiance), [self._now, self._known, radiance], radiance.device)

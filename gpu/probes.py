"""The error of a frame's indirect light, estimated at a few pixels without a reference picture.

At probes, pixels drawn anew each frame, the light of all VPLs is gathered as `exact-vpl` does, but with few rays
(gpu.probe_light). That is done twice: the product of two independent differences is right in the mean where the square
of one would count the probes' own noise. Most of an estimate's noise is the choice of pixels, so many probes with few
rays are best. Errors are large where the picture is bright, so these pixels are drawn more often (resampled importance
sampling, J. Talbot et al. 2005).
"""

from collections import deque
from dataclasses import replace

import numpy as np
import warp as wp

from gpu.device import launch
from gpu.error_model import Estimate
from gpu.gbuffer import GBuffer, reflectance
from gpu.interpolate import irradiance_at
from gpu.probe_light import RAYS, ProbeLight
from gpu.resident import NO_HIT
from gpu.sampling import TO_UNIT, hashed
from gpu.scene.types import Floats
from gpu.transfer import brightness
from gpu.view import View
from gpu.vpl_clusters import VplClusters

# Probes, as many as look at so many VPLs in all, and no more than that.
ON_CUDA, ON_CPU = 1 << 14, 1 << 10
MOST_LOOKS = 1 << 28
# Pixels that a probe is drawn from, and how much of their mean brightness is added to each one's, for errors in the
# dark. With probes drawn evenly an estimate has a deviation of 11.5 over their number's root in a conference room, 5.6
# in a Cornell box and 4.0 in an atrium; in proportion to brightness it is 7.0, 5.4 and 3.3.
CANDIDATES, DIM = wp.constant(16), wp.constant(0.2)
# What counts as white in gpu.metrics; of at least so many probes, and frames at most: those of 32 frames were behind a
# camera that turns.
WHITE_PERCENT, WHITE_PROBES, WHITE_FRAMES = 99.0, 1 << 14, 8
# Where the picture is brightest, which this share of it is not, it is less or more so than the truth.
BRIGHT_PERCENT = 95.0


@wp.func
def picture_at(gbuffer: GBuffer, pixel: int, width: int, height: int, stride: int, listed: wp.array[int],
               irradiance: wp.array[wp.vec3]) -> wp.vec3:  # fmt: skip
    """Radiance of a pixel by the irradiance (pixel,) of the `listed` SPs: black where it sees nothing [W/m²/sr]."""
    if gbuffer.face[pixel] == NO_HIT:
        return wp.vec3(0.0, 0.0, 0.0)
    light = irradiance_at(gbuffer, pixel, width, height, stride, listed, irradiance)
    return wp.cw_mul(reflectance(gbuffer, pixel), light)


@wp.func
def candidate(probe: int, number: int, probes: int, total: int, frame: int) -> int:
    """Candidate `number` of a probe: one pixel of one of equal runs of the image's `total`, another in each frame."""
    index = wp.int64(number) * wp.int64(probes) + wp.int64(probe)
    runs = wp.int64(CANDIDATES) * wp.int64(probes)
    begin = int(index * wp.int64(total) / runs)
    end = int((index + wp.int64(1)) * wp.int64(total) / runs)
    pick = hashed(wp.uint32(int(index)) ^ hashed(wp.uint32(frame)))
    return begin + int(pick % wp.uint32(wp.max(end - begin, 1)))


@wp.kernel
def place_kernel(first: int, total: int, frame: wp.array[int], gbuffer: GBuffer, width: int, height: int, stride: int,
                 listed: wp.array[int], irradiance: wp.array[wp.vec3], pixels: wp.array[int], counts: wp.array[float],
                 radiance: wp.array2d[wp.vec3]) -> None:  # fmt: skip
    """One thread a probe: draws it from its candidates; how many pixels, relative to others, it `counts` for.

    radiance: (4, probe); row 3 becomes the picture at one of the probe's candidates, which are drawn evenly.
    """
    probe = first + wp.tid()
    probes = pixels.shape[0]
    mean = float(0.0)
    for number in range(CANDIDATES):
        pixel = candidate(probe, number, probes, total, frame[0])
        shown = picture_at(gbuffer, pixel, width, height, stride, listed, irradiance)
        if number == probe % CANDIDATES:
            radiance[3, probe] = shown
        mean += brightness(shown) / float(CANDIDATES)
    state = hashed(wp.uint32(probe) ^ hashed(~wp.uint32(frame[0])))
    rest = (float(state) * TO_UNIT) * (1.0 + DIM) * mean * float(CANDIDATES)
    chosen = candidate(probe, 0, probes, total, frame[0])
    share = float(1.0)
    for number in range(CANDIDATES):
        pixel = candidate(probe, number, probes, total, frame[0])
        bright = brightness(picture_at(gbuffer, pixel, width, height, stride, listed, irradiance)) + DIM * mean
        if rest >= 0.0 and bright > 0.0:
            chosen = pixel
            share = (1.0 + DIM) * mean / bright
        rest -= bright
    pixels[probe] = chosen
    counts[probe] = share


@wp.kernel
def turn_kernel(first: int, frame: wp.array[int]) -> None:
    """One thread: the next frame has other probes and rays, also where this is replayed."""
    frame[first + wp.tid()] += 1


@wp.kernel
def compare_kernel(first: int, gbuffer: GBuffer, width: int, height: int, stride: int, listed: wp.array[int],
                   pixels: wp.array[int], arrived: wp.array[wp.vec3], irradiance: wp.array[wp.vec3],
                   radiance: wp.array2d[wp.vec3]) -> None:  # fmt: skip
    """One thread a probe: its radiance in the picture, and by the two estimates, in rows 0 … 2 [W/m²/sr].

    arrived: as in gpu.probe_light; radiance: (4, probe).
    """
    probe = first + wp.tid()
    pixel = pixels[probe]
    radiance[0, probe] = picture_at(gbuffer, pixel, width, height, stride, listed, irradiance)
    radiance[1, probe] = wp.vec3(0.0, 0.0, 0.0)
    radiance[2, probe] = wp.vec3(0.0, 0.0, 0.0)
    if gbuffer.face[pixel] == NO_HIT:
        return
    reflected = reflectance(gbuffer, pixel)
    this = wp.vec3(0.0, 0.0, 0.0)
    that = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(RAYS):
        this += arrived[(2 * probe) * RAYS + ray]
        that += arrived[(2 * probe + 1) * RAYS + ray]
    radiance[1, probe] = wp.cw_mul(reflected, this)
    radiance[2, probe] = wp.cw_mul(reflected, that)


def white_of(even: Floats, render: Floats, truth: Floats, counts: Floats) -> float:
    """What counts as white of the truth: by a render at pixels drawn `even`ly, and at probes with noisy truth there.

    The noise of probes' own rays makes their brightest brighter, and few clusters make the picture's darker: by the one
    alone errors were taken for 0.90 to 0.96 times what they were, by the other for 1.0 to 1.17 times.
    """
    bright = (render >= np.percentile(even, BRIGHT_PERCENT)) * counts[:, None]
    mean = float(np.sum(bright * render, dtype=np.float64))
    if not mean > 0.0:
        return 0.0
    return float(np.percentile(even, WHITE_PERCENT)) * float(np.sum(bright * truth, dtype=np.float64)) / mean


def clipped_product(render: Floats, one: Floats, other: Floats, counts: Floats, white: float) -> Estimate:
    """MSE (gpu.metrics) of a render (probe, 3) against two independent estimates of the truth; 0 where it is black.

    counts: (probe,), how many pixels each is for, 1 in the mean.
    """
    if white <= 0.0:
        return Estimate(0.0, 0.0)
    x, a, b = (np.clip(np.asarray(values, np.float64) / white, 0.0, 1.0) for values in (render, one, other))
    products = counts * np.mean((x - a) * (x - b), axis=1)
    return Estimate(float(products.mean()), float(products.std() / np.sqrt(len(products))))


class Probes:
    """Probes of the frames of `view`, lit by so many VPLs; its arrays are allocated once."""

    def __init__(self, view: View, vpls: int) -> None:
        self._view = view
        device = view.device
        most = ON_CUDA if device.is_cuda else ON_CPU
        count = min(most, max(MOST_LOOKS // vpls, 1), view.pixels)
        self._frame = wp.zeros(1, dtype=int, device=device)
        self._pixels = wp.zeros(count, dtype=int, device=device)
        self._counts = wp.zeros(count, dtype=float, device=device)
        self._light = ProbeLight(count, device)
        self._radiance = wp.zeros((4, count), dtype=wp.vec3, device=device)
        self._seen: deque[tuple[Floats, ...]] = deque(maxlen=min(-(-WHITE_PROBES // count), WHITE_FRAMES))

    def run(self, vpls: VplClusters) -> None:
        """Gather the light of `vpls` at new probes, before the view's indirect light gets what is not theirs."""
        view, device, count = self._view, self._view.device, len(self._pixels)
        picture = [view.gbuffer, *view.size, view.shading_points.stride, view.shading_points.listed]
        irradiance = view.indirect.irradiance
        launch(turn_kernel, 1, [self._frame], device)
        inputs = [view.pixels, self._frame, *picture, irradiance, self._pixels, self._counts, self._radiance]
        launch(place_kernel, count, inputs, device)
        self._light.gather(view.scene, view.gbuffer, self._pixels, self._frame, vpls)
        inputs = [*picture, self._pixels, self._light.arrived, irradiance, self._radiance]
        launch(compare_kernel, count, inputs, device)

    def estimate(self) -> Estimate:
        """What the probes of the last frame, which is ready, make of its MSE, right in the mean, and of its light."""
        # On a CPU these are the arrays themselves, which the next frame overwrites.
        render, one, other, even = self._radiance.numpy().copy()
        counts = self._counts.numpy().copy()
        self._seen.append((even, render, 0.5 * (one + other), counts))
        white = white_of(*(np.concatenate(values) for values in zip(*self._seen, strict=True)))
        lit = float(np.mean(np.any(even > 0.0, axis=1)))
        return replace(clipped_product(render, one, other, counts, white), lit=lit)

"""The error of a frame's indirect light, estimated at a few pixels without a reference picture.

At probes, pixels drawn anew each frame, the light of all VPLs is gathered as `exact-vpl` does, but with few rays
(gpu.probe_light). That is done twice: the product of two independent differences is right in the mean where the square
of one would count the probes' own noise. Most of an estimate's noise is the choice of pixels (gpu.probe_places), so
many probes with few rays are best.
"""

from collections import deque

import numpy as np
import warp as wp

from gpu.device import launch
from gpu.error_model import Estimate
from gpu.gbuffer import GBuffer, reflectance
from gpu.interpolate import irradiance_at
from gpu.probe_light import RAYS, ProbeLight
from gpu.probe_places import Doubles, ProbePlaces
from gpu.resident import NO_HIT
from gpu.sampling import hashed
from gpu.scene.types import Floats
from gpu.view import View
from gpu.vpl_clusters import VplClusters

# Probes of a frame.
ON_CUDA, ON_CPU = 1 << 14, 1 << 12
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


@wp.kernel
def turn_kernel(first: int, frame: wp.array[int]) -> None:
    """One thread: the next frame has other probes and rays, also where this is replayed."""
    frame[first + wp.tid()] += 1


@wp.func
def even_pixel(probe: int, probes: int, total: int, frame: int) -> int:
    """A pixel of a probe's own of equal runs of the image's `total`, another in each frame."""
    begin = int(wp.int64(probe) * wp.int64(total) / wp.int64(probes))
    end = int(wp.int64(probe + 1) * wp.int64(total) / wp.int64(probes))
    pick = hashed(wp.uint32(probe) ^ hashed(wp.uint32(frame)))
    return begin + int(pick % wp.uint32(wp.max(end - begin, 1)))


@wp.kernel
def compare_kernel(first: int, frame: wp.array[int], gbuffer: GBuffer, width: int, height: int, stride: int,
                   listed: wp.array[int], irradiance: wp.array[wp.vec3], pixels: wp.array[int],
                   arrived: wp.array[wp.vec3], radiance: wp.array2d[wp.vec3]) -> None:  # fmt: skip
    """One thread a probe: its radiance in the picture, and by the two estimates, in rows 0 … 2 [W/m²/sr].

    arrived: as in gpu.probe_light; radiance: (4, probe), of which row 3 becomes the picture at pixels drawn evenly.
    """
    probe = first + wp.tid()
    even = even_pixel(probe, pixels.shape[0], width * height, frame[0])
    radiance[3, probe] = picture_at(gbuffer, even, width, height, stride, listed, irradiance)
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

    even, render, truth: (channel, probe); counts: (probe,). The noise of probes' own rays makes their brightest
    brighter, and few clusters make the picture's darker: by the one alone errors were taken for 0.90 to 0.96 times what
    they were, by the other for 1.0 to 1.17 times.
    """
    least, white = np.percentile(even, [BRIGHT_PERCENT, WHITE_PERCENT])
    bright = (render >= least) * counts
    mean = float(np.sum(bright * render, dtype=np.float64))
    if not mean > 0.0:
        return 0.0
    return float(white) * float(np.sum(bright * truth, dtype=np.float64)) / mean


def clipped_products(render: Floats, one: Floats, other: Floats, white: float) -> Doubles:
    """Squared errors (gpu.metrics) of a render by two independent estimates of the truth, each (channel, probe).

    (probe,); right in the mean, 0 if the render is black.
    """
    if white <= 0.0:
        return np.zeros(render.shape[1])
    x, a, b = (np.clip(np.asarray(values, np.float64) / white, 0.0, 1.0) for values in (render, one, other))
    products: Doubles = np.mean((x - a) * (x - b), axis=0)
    return products


class Probes:
    """Probes of the frames of `view`; its arrays are allocated once."""

    def __init__(self, view: View) -> None:
        self._view = view
        device = view.device
        count = min(ON_CUDA if device.is_cuda else ON_CPU, view.pixels)
        self._frame = wp.zeros(1, dtype=int, device=device)
        self._places = ProbePlaces(view.size, count, device)
        self._light = ProbeLight(count, device)
        self._radiance = wp.zeros((4, count), dtype=wp.vec3, device=device)
        self._seen: deque[tuple[Floats, ...]] = deque(maxlen=min(-(-WHITE_PROBES // count), WHITE_FRAMES))

    def run(self, vpls: VplClusters) -> None:
        """Gather the light of `vpls` at new probes, before the view's indirect light gets what is not theirs."""
        view, device, places = self._view, self._view.device, self._places
        picture = [view.gbuffer, *view.size, view.shading_points.stride, view.shading_points.listed]
        launch(turn_kernel, 1, [self._frame], device)
        places.draw(self._frame)
        self._light.gather(view.scene, view.gbuffer, places.pixels, self._frame, vpls)
        inputs = [self._frame, *picture, view.indirect.irradiance, places.pixels, self._light.arrived, self._radiance]
        launch(compare_kernel, len(places.pixels), inputs, device)

    def estimate(self) -> Estimate:
        """What the probes of the last frame, which is ready, make of its MSE, right in the mean, and of its light.

        To be asked for once a frame: the next frame's probes go to where these found errors.
        """
        # Copies: on a CPU arrays are the device's own, which the next frame overwrites.
        render, one, other, even = self._radiance.numpy().transpose(0, 2, 1).copy()
        counts = self._places.counts.numpy().copy()
        self._seen.append((even, render, 0.5 * (one + other), counts))
        white = white_of(*(np.concatenate(values, axis=-1) for values in zip(*self._seen, strict=True)))
        lit = float(np.mean(even.max(axis=0) > 0.0))
        products = clipped_products(render, one, other, white)
        self._places.learn(products)
        errors = counts * products
        return Estimate(float(errors.mean()), float(errors.std() / np.sqrt(len(errors))), lit)

"""The error of a frame's indirect light, estimated at a few pixels without a reference picture.

At probes, pixels drawn anew each frame, the light of all VPLs is gathered as `exact-vpl` does, but with few rays
(gpu.adaptive.probe_gather). That is done twice: the product of two independent differences is right in the mean where
the square of one would count the probes' own noise. Most of an estimate's noise is the choice of pixels
(gpu.adaptive.probe_placement), so many probes with few rays are best.
"""

import warp as wp
from warp.utils import array_sum

from gpu.adaptive.error_model import Estimate
from gpu.adaptive.probe_gather import ProbeLight
from gpu.adaptive.probe_placement import ProbePlaces
from gpu.adaptive.probe_white_point import Picture, ProbeRadiance, WhitePoint, radiance_at, white_of
from gpu.core.device import allocate, launch
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.gbuffer.gbuffer import reflectance
from gpu.gbuffer.point_list import PointList
from gpu.vpl.vpl_clusters import VplClusters

# Probes of a frame.
ON_CUDA, ON_CPU = 1 << 14, 1 << 12


@wp.kernel
def next_probes_kernel(first: int, frame: wp.array[int]) -> None:
    """One thread: the next frame has other probes and rays, also where this is replayed."""
    frame[first + wp.tid()] += 1


@wp.kernel
def probe_radiance_kernel(first: int, picture: Picture, points: PointList, light: wp.array[wp.vec3],
                          radiance: ProbeRadiance) -> None:  # fmt: skip
    """One thread a probe: its radiance in the picture, and by the two estimates [W/m²/sr].

    light (probe, estimate), flattened.
    """
    probe = first + wp.tid()
    pixel = points.pixels[probe]
    radiance.render[probe] = radiance_at(picture, pixel)
    reflected = wp.vec3(0.0, 0.0, 0.0)
    if picture.gbuffer.face[pixel] != NO_HIT:
        reflected = reflectance(picture.gbuffer, pixel)
    radiance.one[probe] = wp.cw_mul(reflected, light[2 * probe])
    radiance.other[probe] = wp.cw_mul(reflected, light[2 * probe + 1])


@wp.func
def clipped(radiance: wp.vec3, white: float) -> wp.vec3:
    """Radiance as errors count it, 0 … 1."""
    return wp.min(wp.max(radiance / white, wp.vec3(0.0, 0.0, 0.0)), wp.vec3(1.0, 1.0, 1.0))


@wp.kernel
def probe_error_kernel(first: int, quantiles: wp.array[float], whole: wp.array[wp.vec2], counts: wp.array[float],
                       radiance: ProbeRadiance, products: wp.array[float],
                       errors: wp.array[wp.vec2]) -> None:  # fmt: skip
    """One thread a probe: its squared error (gpu.film.metrics) by two estimates of the truth, right in the mean.

    quantiles, whole: of gpu.adaptive.probe_white_point; errors (probe,): times what the probe counts for, and the
    square of that. All are 0 if the picture is black, and not finite if white is not.
    """
    probe = first + wp.tid()
    white = white_of(quantiles, whole)
    product = white
    if white > 0.0 and wp.isfinite(white):
        shown = clipped(radiance.render[probe], white)
        product = (
            wp.dot(shown - clipped(radiance.one[probe], white), shown - clipped(radiance.other[probe], white)) / 3.0
        )
    products[probe] = product
    error = counts[probe] * product
    errors[probe] = wp.vec2(error, error * error)


@wp.kernel
def error_estimate_kernel(first: int, sums: wp.array[wp.vec2], probes: int, lit: wp.array[int], even: int,
                    estimate: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread: error, deviation and lit share of gpu.adaptive.error_model.Estimate, by `sums` (1,) of `errors`.

    lit (1,): how many of so many `even` pixels have light.
    """
    mean = sums[first + wp.tid()] / float(probes)
    variance = wp.max(mean[1] - mean[0] * mean[0], 0.0)
    estimate[0] = wp.vec3(mean[0], wp.sqrt(variance / float(probes)), float(lit[0]) / float(even))


class Probes:
    """Probes of pictures of `size` (width, height), of one viewer; its arrays are allocated once."""

    def __init__(self, size: tuple[int, int], device: wp.Device, *, tinted: bool = False) -> None:
        """tinted: as of gpu.vpl.shadow_rays.shadow_rays."""
        self._device = device
        count = min(ON_CUDA if device.is_cuda else ON_CPU, size[0] * size[1])
        self._frame = wp.zeros(1, dtype=int, device=device)
        self._places = ProbePlaces(size, count, device)
        self._light = ProbeLight(count, device, tinted=tinted)
        self._white = WhitePoint(size[0] * size[1], count, device)
        self._radiance: ProbeRadiance = allocate(ProbeRadiance, count, device)
        self._products = wp.zeros(count, dtype=float, device=device)
        self._errors = wp.zeros(count, dtype=wp.vec2, device=device)
        self._sums = wp.zeros(1, dtype=wp.vec2, device=device)
        self._estimate = StagingBuffer(wp.zeros(1, dtype=wp.vec3, device=device))

    def run(self, scene: SceneData, picture: Picture, vpls: VplClusters, *, again: bool = False) -> None:
        """Estimate the error of a picture's indirect light of `vpls`, before it gets what is not theirs.

        again: the last frame was of the same view and VPLs, so that what its probes know of these serves this one, too.
        The next frame's probes go to where these found errors.
        """
        device, places, white, frame = self._device, self._places, self._white, self._frame
        radiance = self._radiance
        count = len(self._products)
        if not again:
            launch(next_probes_kernel, 1, [frame], device)
            places.draw(frame)
            self._light.gather(scene, picture.gbuffer, places.points, frame, vpls)
        launch(probe_radiance_kernel, count, [picture, places.points, self._light.light, radiance], device)
        white.find(frame, picture, places.counts, radiance)
        inputs = [white.quantiles, white.whole, places.counts, radiance, self._products, self._errors]
        launch(probe_error_kernel, count, inputs, device)
        places.learn(self._products)
        array_sum(self._errors, self._sums)
        launch(error_estimate_kernel, 1, [self._sums, count, white.lit, white.even, self._estimate.array], device)
        self._estimate.download()

    def estimate(self) -> Estimate:
        """What the probes of the last frame, which is ready, make of its MSE, right in the mean, and of its light."""
        error, deviation, lit = self._estimate.host[0].tolist()
        return Estimate(error, deviation, lit)

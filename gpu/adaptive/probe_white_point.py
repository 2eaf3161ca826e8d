"""What counts as white (gpu.film.metrics) where the truth is known at probes alone, and with noise
(gpu.adaptive.error_probes).

The noise of probes' own rays makes their brightest brighter than the truth's, and few clusters make the picture's
darker: by the one alone errors were taken for 0.90 to 0.96 times what they were, by the other for 1.0 to 1.17 times. So
white is the picture's, at pixels drawn evenly, times how much brighter the truth is where the picture is brightest.
"""

from dataclasses import dataclass

import warp as wp
from warp.utils import array_sum

from gpu.core.device import launch, launch_together
from gpu.core.image_size import ImageSize, image_size
from gpu.core.intrinsics import count_in
from gpu.core.radix_sort import running_total
from gpu.core.search import upper_bound
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import SparseShadingParameters, irradiance_at
from gpu.sampling.sobol import hashed

# Share of the values that are below white, as gpu.film.metrics defines it.
WHITE_SHARE = wp.constant(0.99)
# Values are counted by a float's bits without so many of the last, in steps of 1/128 of an octave, up to this one.
DROPPED_BITS, LARGEST = wp.constant(16), wp.constant(3.0e38)
INFINITE = 0x7F800000
BINS = (INFINITE >> int(DROPPED_BITS)) + 1


@dataclass(frozen=True)
class WhitePointParameters:
    """even: pixels whose radiance tells the picture's, at most; bright_share: of their values those that are below what
    is bright, where the picture is compared with the truth.
    """

    even: int = 1 << 16
    bright_share: float = 0.95


@wp.struct
class Picture:
    """Indirect light of an image of `width` and `height`, as gpu.gbuffer.sparse_shading reads it: irradiance (pixel,)
    [W/m²].
    """

    gbuffer: GBuffer
    image: ImageSize
    sparse: SparseShadingParameters
    listed: wp.array[int]
    irradiance: wp.array[wp.vec3]


@wp.struct
class ProbeRadiance:
    """Radiance at probes (probe,) [W/m²/sr]: in the picture, and of the truth by two independent estimates."""

    render: wp.array[wp.vec3]
    one: wp.array[wp.vec3]
    other: wp.array[wp.vec3]


def picture_of(gbuffer: GBuffer, size: tuple[int, int], points: ShadingPoints, irradiance: wp.array) -> Picture:
    """The picture of `size` (width, height) that the `irradiance` (pixel,) of `points` makes."""
    picture = Picture()
    picture.gbuffer, picture.image = gbuffer, image_size(size)
    picture.sparse, picture.listed, picture.irradiance = points.sparse, points.listed, irradiance
    return picture


@wp.func
def radiance_at(picture: Picture, pixel: int) -> wp.vec3:
    """Radiance of a pixel: black where it sees nothing [W/m²/sr]."""
    gbuffer = picture.gbuffer
    if gbuffer.face[pixel] == NO_HIT:
        return wp.vec3(0.0, 0.0, 0.0)
    light = irradiance_at(gbuffer, pixel, picture.image, picture.sparse, picture.listed, picture.irradiance)
    return wp.cw_mul(reflectance(gbuffer, pixel), light)


@wp.func
def even_pixel(number: int, count: int, total: int, frame: int) -> int:
    """A pixel of its own of each of `count` equal runs of the image's `total`, another in each frame."""
    begin = int(wp.int64(number) * wp.int64(total) / wp.int64(count))
    end = int(wp.int64(number + 1) * wp.int64(total) / wp.int64(count))
    pick = hashed(wp.uint32(number) ^ hashed(wp.uint32(frame)))
    return begin + int(pick % wp.uint32(wp.max(end - begin, 1)))


@wp.func
def bin_of(value: float) -> int:
    """The bin that a value is counted in; those of larger values come later, and what is not above zero comes first."""
    if not value > 0.0:
        return 0
    return wp.cast(wp.min(value, LARGEST), int) >> DROPPED_BITS


@wp.kernel
def radiance_histogram_kernel(first: int, frame: wp.array[int], count: int, picture: Picture, bins: wp.array[int],
                              lit: wp.array[int]) -> None:  # fmt: skip
    """One thread an even pixel: counts each channel of its radiance in `bins`, and whether it has light in `lit` (1,).

    frame (1,): others in each.
    """
    pixel = even_pixel(first + wp.tid(), count, picture.image.width * picture.image.height, frame[0])
    radiance = radiance_at(picture, pixel)
    if wp.max(radiance) > 0.0:
        count_in(lit, 0)
    for channel in range(3):
        count_in(bins, bin_of(radiance[channel]))


@wp.func
def least_of(number: int) -> float:
    """The least value of a bin."""
    return wp.cast(number << DROPPED_BITS, float)


@wp.kernel
def radiance_quantile_kernel(
    first: int, totals: wp.array[int], bright_share: float, quantiles: wp.array[float]
) -> None:
    """One thread a quantile: what is bright, and what is white in the picture, by running `totals` of bins.

    Values are taken to lie evenly within a bin, and to be 0 in the first.
    """
    number = first + wp.tid()
    last = totals.shape[0] - 1
    rank = wp.where(number == 0, bright_share, WHITE_SHARE) * float(totals[last])
    place = upper_bound(totals, last, int(rank))
    quantiles[number] = 0.0
    if place > 0:
        before = totals[place - 1]
        inside = (rank - float(before)) / float(wp.max(totals[place] - before, 1))
        quantiles[number] = wp.lerp(least_of(place), least_of(place + 1), inside)


@wp.kernel
def probe_brightness_kernel(first: int, quantiles: wp.array[float], counts: wp.array[float],
                            radiance: ProbeRadiance, bright: wp.array[wp.vec2]) -> None:  # fmt: skip
    """One thread a probe: what the picture and the truth, by two estimates of it, have where the picture is bright.

    counts (probe,): how many pixels each stands for.
    """
    probe = first + wp.tid()
    found = wp.vec2(0.0, 0.0)
    for channel in range(3):
        shown = radiance.render[probe][channel]
        if shown >= quantiles[0]:
            found += wp.vec2(shown, 0.5 * (radiance.one[probe][channel] + radiance.other[probe][channel]))
    bright[probe] = found * counts[probe]


@wp.func
def white_of(quantiles: wp.array[float], whole: wp.array[wp.vec2]) -> float:
    """White by what a `WhitePoint` has found [W/m²/sr]; 0 if the picture is black. quantiles (2,), whole (1,): its."""
    if not whole[0][0] > 0.0:
        return 0.0
    return quantiles[1] * whole[0][1] / whole[0][0]


class WhitePoint:
    """White of a picture of `pixels` pixels that `probes` probes look at; its arrays are allocated once.

    quantiles (2,), whole (1,): what `white_of` takes; lit (1,), of `even` pixels how many have light.
    """

    def __init__(
        self, pixels: int, probes: int, device: wp.Device, parameters: WhitePointParameters | None = None
    ) -> None:
        self._device, self._parameters = device, parameters or WhitePointParameters()
        self.even = min(self._parameters.even, pixels)
        self._bins = wp.zeros(BINS, dtype=int, device=device)
        self._bright = wp.zeros(probes, dtype=wp.vec2, device=device)
        self.lit = wp.zeros(1, dtype=int, device=device)
        self.quantiles = wp.zeros(2, dtype=float, device=device)
        self.whole = wp.zeros(1, dtype=wp.vec2, device=device)

    def find(self, frame: wp.array, picture: Picture, counts: wp.array, radiance: ProbeRadiance) -> None:
        """Look at other pixels in each `frame` (1,); the others as `probe_brightness_kernel` takes them."""
        device, bins, bright = self._device, self._bins, self._bright
        bins.zero_()
        self.lit.zero_()
        launch_together(radiance_histogram_kernel, self.even, [frame, self.even, picture, bins, self.lit], device)
        running_total(bins, bins)
        launch(radiance_quantile_kernel, 2, [bins, self._parameters.bright_share, self.quantiles], device)
        launch(probe_brightness_kernel, len(bright), [self.quantiles, counts, radiance, bright], device)
        array_sum(bright, self.whole)

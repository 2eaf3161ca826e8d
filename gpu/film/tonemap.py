"""From linear radiance to display: automatic exposure, a filmic tone curve and sRGB; and a check of every pixel."""

import warp as wp

from gpu.core.device import allocate, launch
from gpu.core.staging_buffer import StagingBuffer

# A GPU's threads, each with few pixels; so many others sum up what they find.
PARTIALS = 16_384
SUMS = 128
# Luminance below this share of an even picture's is black to the exposure; logarithms stay finite.
DARKEST = wp.constant(1.0e-20)
BRIGHTEST = wp.constant(1.0e20)


@wp.struct
class Tally:
    """Sums over some pixels each, (sum,): of log luminance, of lit pixels, and of pixels with non-finite radiance."""

    log_luminance: wp.array[float]
    lit: wp.array[int]
    nonfinite: wp.array[int]


@wp.func
def luminance(radiance: wp.vec3) -> float:
    """Luminance of linear Rec. 709."""
    return wp.dot(radiance, wp.vec3(0.2126, 0.7152, 0.0722))


@wp.func
def filmic(x: float) -> float:
    """K. Narkowicz's fit of the ACES curve, 2015."""
    return wp.clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)


@wp.func
def srgb(x: float) -> float:
    """IEC 61966-2-1."""
    return wp.where(x <= 0.0031308, 12.92 * x, 1.055 * wp.pow(x, 1.0 / 2.4) - 0.055)


@wp.kernel
def tally_luminance_kernel(first: int, radiance: wp.array[wp.vec3], out: Tally) -> None:
    """One thread a partial sum over every PARTIALS-th pixel: no atomics, so the same bits every time.

    radiance (pixel,) linear Rec. 709 [W/m²/sr].
    """
    partial = first + wp.tid()
    total = float(0.0)
    lit = int(0)
    nonfinite = int(0)
    pixel = int(partial)
    while pixel < radiance.shape[0]:
        value = luminance(radiance[pixel])
        if not wp.isfinite(radiance[pixel]):
            nonfinite += 1
        elif value > DARKEST:
            total += wp.log(wp.min(value, BRIGHTEST))
            lit += 1
        pixel += PARTIALS
    out.log_luminance[partial] = total
    out.lit[partial] = lit
    out.nonfinite[partial] = nonfinite


@wp.kernel
def fold_tally_kernel(first: int, tally: Tally, out: Tally) -> None:
    """One thread a sum over every SUMS-th partial sum."""
    place = first + wp.tid()
    total = float(0.0)
    lit = int(0)
    nonfinite = int(0)
    for partial in range(place, PARTIALS, SUMS):
        total += tally.log_luminance[partial]
        lit += tally.lit[partial]
        nonfinite += tally.nonfinite[partial]
    out.log_luminance[place] = total
    out.lit[place] = lit
    out.nonfinite[place] = nonfinite


@wp.kernel
def exposure_kernel(first: int, sums: Tally, fixed: float, middle_grey: float, exposure: wp.array[float],
                    nonfinite: wp.array[int]) -> None:  # fmt: skip
    """One thread: adds up the sums; exposure (1,) becomes `fixed`, or where that is 0 what the picture needs.

    nonfinite (1,): pixels with radiance that is not finite.
    """
    _single = first + wp.tid()
    total = float(0.0)
    lit = int(0)
    bad = int(0)
    for place in range(SUMS):
        total += sums.log_luminance[place]
        lit += sums.lit[place]
        bad += sums.nonfinite[place]
    exposure[0] = fixed
    if fixed == 0.0:
        exposure[0] = middle_grey / wp.exp(total / float(wp.max(lit, 1)))
    nonfinite[0] = bad


@wp.kernel
def tonemap_kernel(first: int, radiance: wp.array[wp.vec3], exposure: wp.array[float],
                   pixels: wp.array2d[wp.uint8]) -> None:  # fmt: skip
    """One thread a pixel. radiance (pixel,) linear Rec. 709 [W/m²/sr]; exposure (1,); pixels (pixel, 3) sRGB 0–255."""
    pixel = first + wp.tid()
    colour = radiance[pixel] * exposure[0]
    for channel in range(3):
        # A non-finite radiance is a bug upstream; show it (magenta) rather than hide it.
        value = wp.where(wp.isfinite(colour[channel]), srgb(filmic(wp.max(colour[channel], 0.0))), float(channel != 1))
        pixels[pixel, channel] = wp.uint8(value * 255.0 + 0.5)


class Tonemap:
    """Display of images of `pixels` pixels; `pixels` (pixel, 3) uint8 holds what the last run made.

    middle_grey: the reflectance that the geometric mean of a picture's luminance is shown as.
    """

    def __init__(self, pixels: int, device: wp.Device, *, middle_grey: float = 0.18) -> None:
        self.device, self._middle_grey = device, middle_grey
        self.pixels = wp.zeros((pixels, 3), dtype=wp.uint8, device=device)
        self._nonfinite = StagingBuffer(wp.zeros(1, dtype=int, device=device))
        self._exposure = wp.zeros(1, dtype=float, device=device)
        self._tally: Tally = allocate(Tally, PARTIALS, device)
        self._sums: Tally = allocate(Tally, SUMS, device)

    def run(self, radiance: wp.array, exposure: float | None) -> None:
        """Write `radiance` (pixel,) as sRGB bytes; `exposure` multiplies it, None chooses one for the picture.

        Source: K. Narkowicz, "ACES filmic tone mapping curve", 2015; middle grey: E. Reinhard et al. 2002, Eq. 1–2.
        """
        launch(tally_luminance_kernel, PARTIALS, [radiance, self._tally], self.device)
        launch(fold_tally_kernel, SUMS, [self._tally, self._sums], self.device)
        inputs = [self._sums, exposure or 0.0, self._middle_grey, self._exposure, self._nonfinite.array]
        launch(exposure_kernel, 1, inputs, self.device)
        self._nonfinite.download()
        launch(tonemap_kernel, len(radiance), [radiance, self._exposure, self.pixels], self.device)

    def nonfinite(self) -> int:
        """How many pixels of the last run, which is ready, have non-finite radiance."""
        return int(self._nonfinite.host[0])

"""The size of frames while the camera moves: as large as comes in time, by what earlier frames took.

The scaler picks the size of frames for usual counts of clusters, gpu.adaptive.governor picks the counts at a fixed size
for a wanted time or error; never both for one viewer: settings with a target are rendered at full size, since fewer
pixels would only let counts grow.
"""

from math import sqrt

from gpu.settings import RenderSettings

# Sides of moving frames as shares of the wanted size. Few, since each size has device memory of its own.
SCALES = (1.0, 0.75, 0.5, 0.35, 0.25)
# What a frame may take by itself, 40 a second: 30 ms from pose to picture with encoding, network and decoding. And from
# the turn being wanted to the picture being rendered, the wait for other viewers included: 27 a second.
TARGET_MS, CROWDED_MS = 25.0, 37.0
# A size is left for the next smaller one above this share of the target, and for the next larger one only where that
# is expected below the other: the gap keeps it from swinging.
TOO_SLOW, FAST_ENOUGH = 1.15, 0.8
# Frames of one size before it is judged again; a frame this many times too slow is enough alone.
JUDGED_FRAMES, AT_ONCE = 4, 2.0
# The first frames of a size may wait for arrays, kernels and graphs: once for each size, being too slow by these does
# not keep it from being tried again.
FIRST_FRAMES = 3
# What a frame takes whatever its size, as a share of what one of full size does: clusters and their visibility.
FIXED_SHARE = 0.25
# Frames until a size that was too slow is tried again: other viewers may have left.
AGAIN = 400
FIRST_PIXELS = 640 * 360  # before anything was measured
LEAST_SIDE = 64  # px; smaller ones show nothing
# Smaller frames come no sooner from a GPU: an H100 renders 650 of 480×270 a second for 16 viewers, 970 of these, and in
# a service, where the host's part counts, 660 of 120×68.
LEAST_GPU_PIXELS = 320 * 180


class ResolutionScaler:
    """Chooses the scale of one viewer's moving frames, unless the viewer or its settings do.

    least_pixels: of frames whose size it chooses, if the wanted size has as many.
    """

    def __init__(self, least_pixels: int = 0) -> None:
        self._least_pixels, self._floor = least_pixels, 0.0
        self._scale: float | None = None
        self._mean_ms = 0.0
        self._frames = 0
        self._total = 0
        self._too_slow: dict[float, int] = {}  # by scale, at which of all frames
        self._forgiven: set[float] = set()

    def restart(self) -> None:
        """Other settings or another scene: what was measured no longer counts."""
        self._scale = None
        self._frames = 0
        self._too_slow.clear()
        self._forgiven.clear()

    def size(self, full: tuple[int, int], settings: RenderSettings, locked: float | None = None) -> tuple[int, int]:
        """Width and height of the next moving frame; full: of a still one; locked: the scale that the viewer wants."""
        if locked is None and settings.has_target:
            locked = 1.0
        if locked is not None:
            self.restart()  # frames of a size that it did not choose tell it nothing
            return _scaled(full, locked)
        if self._scale is None:
            self._scale = next((scale for scale in SCALES if _pixels(full, scale) <= FIRST_PIXELS), SCALES[-1])
        self._floor = sqrt(self._least_pixels / _pixels(full, 1.0))
        return _scaled(full, min(max(self._scale, self._floor), 1.0))

    def observe(self, render_ms: float, waited_ms: float = 0.0) -> None:
        """A moving frame of the chosen scale took so long, after it had waited for its turn."""
        if self._scale is None:
            return
        milliseconds = max(render_ms, (waited_ms + render_ms) * TARGET_MS / CROWDED_MS)
        self._frames += 1
        self._total += 1
        self._mean_ms += (milliseconds - self._mean_ms) / min(self._frames, JUDGED_FRAMES)
        enough = self._frames >= JUDGED_FRAMES
        index = SCALES.index(self._scale)
        if self._mean_ms > TOO_SLOW * TARGET_MS * (1.0 if enough else AT_ONCE):
            if self._frames > FIRST_FRAMES or self._scale in self._forgiven:
                self._too_slow[self._scale] = self._total
            self._forgiven.add(self._scale)
            last = next((n for n, scale in enumerate(SCALES) if scale <= self._floor), len(SCALES) - 1)
            while index < last and self._expected(SCALES[index]) > FAST_ENOUGH * TARGET_MS:
                index += 1
        elif enough and index > 0 and self._worth_trying(SCALES[index - 1]):
            index -= 1
        if SCALES[index] != self._scale:
            self._scale = SCALES[index]
            self._frames = 0

    def _worth_trying(self, scale: float) -> bool:
        rested = scale not in self._too_slow or self._total - self._too_slow[scale] > AGAIN
        return rested and self._expected(scale) < FAST_ENOUGH * TARGET_MS

    def _expected(self, scale: float) -> float:
        """Milliseconds of a frame of this scale, by those of the chosen one."""
        assert self._scale is not None
        return self._mean_ms * _cost(max(scale, self._floor)) / _cost(max(self._scale, self._floor))


def _cost(scale: float) -> float:
    return FIXED_SHARE + (1.0 - FIXED_SHARE) * scale * scale


def _pixels(full: tuple[int, int], scale: float) -> float:
    return full[0] * full[1] * scale * scale


def _scaled(full: tuple[int, int], scale: float) -> tuple[int, int]:
    scale = max(scale, min(1.0, LEAST_SIDE / min(full)))
    return max(1, round(full[0] * scale)), max(1, round(full[1] * scale))

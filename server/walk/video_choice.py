"""Whether a viewer's moving frames come as video, whose pictures tell what has changed, or as JPEGs, each by itself.

Video takes a tenth of the bytes, but looks softer and takes the server's processor: it is for lines on which JPEGs come
late. What a byte takes on a line is the slope of the round trips of frames over their sizes, by least squares.
"""

from collections import deque
from collections.abc import Callable
from statistics import fmean
from time import monotonic

# JPEGs of the usual size that take a line so long are late; where they would take half of that, they are not.
LATE_SECONDS, EARLY_SECONDS = 0.03, 0.015
SMALL_BYTES = 8192  # JPEGs no larger than that on average are not what makes a line slow
REMEMBERED_FRAMES = 64  # of all kinds, whose trips count
USUAL_FRAMES = 16  # JPEGs, of which the usual size is the mean
JUDGED_FRAMES = 8  # between two looks
STAYS_FRAMES = 240  # before JPEGs are tried again: each change shows
LEAST_SPREAD = 0.05  # standard deviation of sizes, as a share of their mean, below which they tell no slope


class VideoChoice:
    """Chooses for one viewer, by how many bytes its frames have and when they are acknowledged."""

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self._now = now
        self._sent: dict[int, tuple[float, int]] = {}  # when, and bytes, by frame that is not acknowledged
        self._trips: deque[tuple[int, float]] = deque(maxlen=REMEMBERED_FRAMES)  # bytes, seconds
        self._jpegs: deque[int] = deque(maxlen=USUAL_FRAMES)  # bytes of moving ones
        self._frames = 0  # acknowledged since the last change
        self.is_video = False

    def sent(self, frame: int, size: int, *, is_moving_jpeg: bool) -> None:
        """A frame of `size` bytes is on its way."""
        self._sent[frame] = self._now(), size
        if is_moving_jpeg:
            self._jpegs.append(size)

    def acknowledged(self, frame: int) -> None:
        """A viewer has this frame and all before it."""
        sent = self._sent.get(frame)
        self._sent = {number: it for number, it in self._sent.items() if number > frame}
        if sent is None:
            return
        at, size = sent
        self._trips.append((size, self._now() - at))
        self._frames += 1
        if self._frames % JUDGED_FRAMES == 0 and self._jpegs:
            self._judge(fmean(self._jpegs))

    def _judge(self, usual: float) -> None:
        seconds = _seconds_a_byte(self._trips) * usual
        late = usual > SMALL_BYTES and seconds > LATE_SECONDS
        early = self._frames >= STAYS_FRAMES and seconds < EARLY_SECONDS
        if early if self.is_video else late:
            self.is_video = not self.is_video
            self._frames = 0


def _seconds_a_byte(trips: deque[tuple[int, float]]) -> float:
    """That a line takes, at least none; none, too, where sizes are too much alike to tell."""
    mean_size, mean_trip = fmean(size for size, _ in trips), fmean(trip for _, trip in trips)
    spread = fmean((size - mean_size) ** 2 for size, _ in trips)
    if spread <= (LEAST_SPREAD * mean_size) ** 2:
        return 0.0
    return max(fmean((size - mean_size) * (trip - mean_trip) for size, trip in trips) / spread, 0.0)

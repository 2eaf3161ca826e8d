"""Whether a viewer's moving frames come as video, whose pictures tell what has changed, or as JPEGs, each by itself.

Video takes a tenth of the bytes, but looks softer and takes the server's processor: it is for lines on which JPEGs come
late. Whether they would come sooner is found by trying, for a few frames; the more often that changed nothing, the
longer until it is tried again.
"""

from collections import deque
from collections.abc import Callable
from statistics import fmean
from time import monotonic

GAIN_SECONDS = 0.03  # of the mean round trip, which video is worth
SMALL_BYTES = 8192  # JPEGs no larger than that on average are not what makes a line slow
# Frames of a kind that are judged, and before them those that may wait for others on their way, or are key frames.
JUDGED_FRAMES, PASSED_FRAMES = 12, 4
# Frames until the other kind is tried: the first time and the last, by doubling, and after it was found to be better.
FIRST_FRAMES, MOST_FRAMES, STAYS_FRAMES = 16, 4096, 240


class VideoChoice:
    """Chooses for one viewer, by how many bytes its moving frames have and when they are acknowledged."""

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self._now = now
        self._sent: dict[int, tuple[float, int, bool]] = {}  # when, bytes, kind, by frame that is not acknowledged
        self._trips: deque[float] = deque(maxlen=JUDGED_FRAMES)  # of the kind of now [s]
        self._sizes: deque[int] = deque(maxlen=JUDGED_FRAMES)
        self._frames = 0  # of the kind of now, since the last change
        self._patience = FIRST_FRAMES
        self._other_trip: float | None = None  # while a kind is tried: what it has to be better than [s]
        self.is_video = False

    def sent(self, frame: int, size: int, *, is_video: bool) -> None:
        """A moving frame of `size` bytes is on its way."""
        self._sent[frame] = self._now(), size, is_video

    def acknowledged(self, frame: int) -> None:
        """A viewer has this frame and all before it."""
        sent = self._sent.get(frame)
        self._sent = {number: it for number, it in self._sent.items() if number > frame}
        if sent is None or sent[2] is not self.is_video:
            return
        at, size, _ = sent
        self._trips.append(self._now() - at)
        self._sizes.append(size)
        self._frames += 1
        if self._other_trip is not None:
            if self._frames >= PASSED_FRAMES + JUDGED_FRAMES:
                self._conclude(self._other_trip)
        elif self._frames >= self._patience and self._may_gain():
            self._other_trip = fmean(self._trips)
            self._become(not self.is_video)

    def _may_gain(self) -> bool:
        return self.is_video or (fmean(self._sizes) > SMALL_BYTES and fmean(self._trips) > GAIN_SECONDS)

    def _conclude(self, other_trip: float) -> None:
        tried = fmean(self._trips)
        jpeg, video = (other_trip, tried) if self.is_video else (tried, other_trip)
        better = jpeg - video >= GAIN_SECONDS
        self._patience = STAYS_FRAMES if better is self.is_video else min(2 * self._patience, MOST_FRAMES)
        self._other_trip = None
        self._become(better)

    def _become(self, is_video: bool) -> None:
        self.is_video = is_video
        self._frames = 0
        self._trips.clear()
        self._sizes.clear()

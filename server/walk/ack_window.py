"""How many frames a viewer may be sent before it acknowledges one: enough to fill the way, too few to queue there.

Like TCP Vegas (L. Brakmo and L. Peterson, 1995): the shortest round trip tells how long the way is; while round trips
are about as short and there would be more to send, the window grows; when they get long, frames queue, and it shrinks.
"""

from collections import deque
from collections.abc import Callable
from math import inf
from time import monotonic

from server.wire.browser import WINDOW

LEAST, MOST = 1, 12
# A round trip so much longer than the shortest one is a queue: by factor, and in seconds, as pages decode unevenly.
QUEUED_FACTOR, QUEUED_SECONDS = 1.5, 0.02
FULL_FACTOR, FULL_SECONDS = 1.2, 0.005
# Round trips that count for the shortest one: the way changes.
REMEMBERED = 100


class AckWindow:
    """The unacknowledged frames of one viewer. `limit` is how many there may be."""

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self.limit = WINDOW
        self.newest = 0  # of the frames that were sent
        self._now = now
        self._sent: dict[int, float] = {}  # frame: when it was sent, inf before that
        self._trips: deque[float] = deque(maxlen=REMEMBERED)
        self._held = False  # a frame had to wait for room since the last change

    def __len__(self) -> int:
        return len(self._sent)

    @property
    def room(self) -> bool:
        """Whether one more frame may be ordered; asking when there is none counts as a wish for a larger window."""
        self._held = self._held or len(self._sent) >= self.limit
        return len(self._sent) < self.limit

    @property
    def waiting_seconds(self) -> float:
        """For how long the oldest frame that was sent has waited for its acknowledgement."""
        return max(0.0, self._now() - min(self._sent.values(), default=inf))

    def add(self, frame: int) -> None:
        """A frame was ordered; its round trip starts with `sent`."""
        self._sent[frame] = inf

    def sent(self, frame: int) -> None:
        """A frame went out."""
        self.newest = frame
        if frame in self._sent:
            self._sent[frame] = self._now()

    def drop(self, frame: int) -> None:
        """A frame will not be sent after all."""
        self._sent.pop(frame, None)

    def acknowledge(self, frame: int) -> None:
        """The viewer has dealt with `frame` and all before it."""
        started = self._sent.get(frame)
        self._sent = {number: time for number, time in self._sent.items() if number > frame}
        if started is not None:
            self._adapt(self._now() - started)

    def _adapt(self, trip: float) -> None:
        self._trips.append(trip)
        shortest = min(self._trips)
        if trip > QUEUED_FACTOR * shortest + QUEUED_SECONDS:
            self.limit = max(LEAST, self.limit - 1)
            self._held = False
        elif self._held and trip < FULL_FACTOR * shortest + FULL_SECONDS:
            self.limit = min(MOST, self.limit + 1)
            self._held = False

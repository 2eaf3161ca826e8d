"""How busy a device was lately."""

from collections.abc import Callable
from time import monotonic

SPAN_SECONDS = 5.0  # that are looked back at, at least


class BusyMeter:
    """The share of the time in which a device worked, over the last whole span."""

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self._now = now
        self._since, self._busy_seconds, self._share = now(), 0.0, 0.0

    def share(self, busy_seconds: float) -> float:
        """From 0 to 1; busy_seconds: that it has worked in all, until now."""
        if (span := self._now() - self._since) >= SPAN_SECONDS:
            self._share = min((busy_seconds - self._busy_seconds) / span, 1.0)
            self._since, self._busy_seconds = self._now(), busy_seconds
        return self._share

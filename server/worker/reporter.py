"""What a job is at, for those who wait: nothing while it is quick, then now and then, and a word at every long step."""

from collections.abc import Callable
from threading import Lock, Timer
from time import monotonic

AGAIN_SECONDS = 0.1


class Reporter:
    """Passes on what a job reports, from `quiet_seconds` after its start and not too often, until it `end`s.

    What was said in the quiet time and still goes on when that is over is passed on then: compiling kernels says it
    once and takes a minute.
    """

    def __init__(self, send: Callable[[str, float], None], quiet_seconds: float) -> None:
        self._send = send
        self._due = monotonic() + quiet_seconds
        self._latest = ("", 0.0)
        self._timer: Timer | None = None
        self._lock = Lock()
        self._ended = False

    def __call__(self, text: str, fraction: float) -> None:
        """The job is at `text`, `fraction` (0 to 1) of which is done."""
        with self._lock:
            self._latest = text, min(max(fraction, 0.0), 1.0)
            wait = self._due - monotonic()
            if wait <= 0.0:
                self._tell()
            elif self._timer is None:
                self._timer = Timer(wait, self._late)
                self._timer.daemon = True
                self._timer.start()

    def end(self) -> None:
        """The job is done: nothing more is passed on."""
        with self._lock:
            self._ended = True
            if self._timer is not None:
                self._timer.cancel()

    def _late(self) -> None:
        with self._lock:
            if self._timer is not None and not self._ended:
                self._tell()

    def _tell(self) -> None:
        if self._timer is not None:  # that would say it again
            self._timer.cancel()
            self._timer = None
        self._due = monotonic() + AGAIN_SECONDS
        self._send(*self._latest)

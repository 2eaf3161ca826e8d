"""How long each turn has had the device, of turns that are under way at once."""

from time import perf_counter


class TurnClock:
    """Time that passes is shared evenly among the turns under way, so that together they take no more than there is."""

    def __init__(self) -> None:
        self._seconds: dict[int, float] = {}  # by request
        self._waiting: set[int] = set()
        self._now = 0.0

    def begin(self, request: int) -> None:
        """A job's turn begins, or goes on."""
        self._share()
        self._seconds.setdefault(request, 0.0)
        self._waiting.discard(request)

    def wait(self, request: int) -> None:
        """A job waits for another one's turn, and uses nothing until its own goes on."""
        self._share()
        self._waiting.add(request)

    def end(self, request: int) -> float:
        """A turn ends, after so many seconds that were its own; 0 for one that is not under way."""
        self._share()
        self._waiting.discard(request)
        return self._seconds.pop(request, 0.0)

    def _share(self) -> None:
        before, self._now = self._now, perf_counter()
        sharing = self._seconds.keys() - self._waiting
        for request in sharing:
            self._seconds[request] += (self._now - before) / len(sharing)

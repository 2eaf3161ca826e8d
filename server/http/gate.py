"""What all who have shown no token may take of a core, together: for being parsed and answered; connecting has another.

A connection's own share (server.http.connection) ends with it, so many of them, or new ones all the time, would take
what one may not. While too much was taken, what such connections send waits here. The gate opens for who has waited the
longest and for who came last by turns: behind a crowd that came at once, or among those who come again and again,
nobody waits long.
"""

import asyncio
from collections.abc import Callable
from time import monotonic
from typing import Protocol

from server.rate_limit import Bucket

SHARE = 0.1  # of a core, usually: what is charged is half of what it takes, as answering is charged at its least
AT_ONCE = 0.05  # s of it
PAUSE_SECONDS = 0.005  # at least, so that others have their turns


class Waiting(Protocol):
    """Who waits."""

    def proceed(self) -> None:
        """Parse what has come."""


class Gate:
    """Opens for one after another, for a share of a core."""

    def __init__(self, share: float = SHARE, now: Callable[[], float] = monotonic) -> None:
        self._share = share
        self._bucket = Bucket(share, AT_ONCE, now)
        self._waiting: dict[Waiting, None] = {}  # who came last at the end
        self._newest = False  # was the last one
        self._timer: asyncio.TimerHandle | None = None

    @property
    def is_open(self) -> bool:
        """Whether something may be done now."""
        return self._bucket.level > 0.0

    def charge(self, seconds: float) -> None:
        """So much of a core was taken."""
        self._bucket.take(seconds)

    def wait(self, waiting: Waiting) -> None:
        """Let it proceed once the gate is open."""
        self._waiting[waiting] = None
        self._set_timer()

    def leave(self, waiting: Waiting) -> None:
        """It waits no more."""
        self._waiting.pop(waiting, None)

    async def opened(self) -> None:
        """Wait until the gate is open."""
        while not self.is_open:
            await asyncio.sleep(self._shut_for())

    def _shut_for(self) -> float:
        return max(-self._bucket.level / self._share, 0.0) + PAUSE_SECONDS

    def _set_timer(self) -> None:
        if self._timer is None and self._waiting:
            self._timer = asyncio.get_running_loop().call_later(self._shut_for(), self._let_in)

    def _let_in(self) -> None:
        self._timer = None
        try:
            while self._waiting and self.is_open:
                self._newest = not self._newest
                next_one = next(reversed(self._waiting) if self._newest else iter(self._waiting))
                del self._waiting[next_one]
                next_one.proceed()
        finally:
            self._set_timer()

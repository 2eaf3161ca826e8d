"""Places for what lasts, such as event streams: so many in all, and so many for one client."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from server.refusals import TooBusyError

# The client that a task works for, as clients are counted (server.addresses); nobody, where it is the service itself.
asker: ContextVar[str] = ContextVar("lumenwalk_asker", default="")


class Places:
    """`what` takes places: `most` in all, `most_of_one` for one client."""

    def __init__(self, what: str, most: int, most_of_one: int) -> None:
        self._what = what
        self._most = most
        self._most_of_one = most_of_one
        self._taken: Counter[str] = Counter()

    @property
    def total(self) -> int:
        """How many are taken."""
        return self._taken.total()

    @contextmanager
    def taken(self, client: str) -> Iterator[None]:
        """Take one; TooBusyError when there is none."""
        if self._taken[client] >= self._most_of_one or self._taken.total() >= self._most:
            raise TooBusyError(f"there are too many {self._what} already; end one, or try again later")
        self._taken[client] += 1
        try:
            yield
        finally:
            self._taken[client] -= 1
            self._taken += Counter()  # forgets who has none

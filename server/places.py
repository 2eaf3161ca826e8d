"""Places for what lasts, such as event streams: so many in all, and so many for one client."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from server.refusals import TooBusyError


class Places:
    """`what` takes places: `most` in all, `most_of_one` for one client."""

    def __init__(self, what: str, most: int, most_of_one: int) -> None:
        self._what = what
        self._most = most
        self._most_of_one = most_of_one
        self._taken: Counter[str] = Counter()

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

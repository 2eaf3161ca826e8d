"""Token buckets: how often something may happen, with a little at once."""

from collections.abc import Callable, Hashable
from time import monotonic

MAX_REMEMBERED = 10_000


class Bucket:
    """Holds `burst` at first and at most, and gains `rate` a second."""

    def __init__(self, rate: float, burst: float, now: Callable[[], float] = monotonic) -> None:
        self._rate = rate
        self._burst = burst
        self._now = now
        self._level = burst
        self._at = now()

    @property
    def level(self) -> float:
        """What is in it now; below zero is what was taken in advance."""
        now = self._now()
        self._level = min(self._burst, self._level + self._rate * (now - self._at))
        self._at = now
        return self._level

    def spend(self) -> bool:
        """Take one if there is one."""
        if self.level < 1.0:
            return False
        self._level -= 1.0
        return True

    def take(self, amount: float = 1.0) -> float:
        """Take it, in advance if there is too little; returns the seconds to wait until that is made up for."""
        self._level = self.level - amount
        return max(-self._level / self._rate, 0.0)


class Buckets:
    """A bucket for each of many keys, such as addresses. Where they are too many, those that nothing was taken of for
    longest are forgotten, which are full again unless there is an attack from everywhere.
    """

    def __init__(self, rate: float, burst: float, now: Callable[[], float] = monotonic) -> None:
        self._of = rate, burst, now
        self._buckets: dict[Hashable, Bucket] = {}  # in the order in which was taken of them last

    def empty(self, key: Hashable) -> bool:
        """Whether nothing is left for `key`."""
        return key in self._buckets and self._buckets[key].level < 1.0

    def take(self, key: Hashable, amount: float = 1.0) -> None:
        """Take of `key`'s."""
        bucket = self._buckets.pop(key, None) or Bucket(*self._of)
        if len(self._buckets) >= MAX_REMEMBERED:
            del self._buckets[next(iter(self._buckets))]
        self._buckets[key] = bucket
        bucket.take(amount)

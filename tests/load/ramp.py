"""The largest number of viewers that still get a service level: a list of numbers, or doubling, then bisection."""

from collections.abc import Awaitable, Callable, Sequence

Fits = Callable[[int], Awaitable[bool]]


async def search(fits: Fits, most: int) -> int:
    """The largest number up to `most` that fits, 0 if not even one does.

    Doubles until one does not fit, then bisects: at most 2·log₂(most) trials. What fits fewer is taken to fit them all.
    """
    good, bad = 0, most + 1
    while bad - good > 1:
        trial = min(max(2 * good, 1), most) if bad > most else (good + bad) // 2
        if await fits(trial):
            good = trial
        else:
            bad = trial
    return good


async def climb(fits: Fits, numbers: Sequence[int]) -> int:
    """Try all of these numbers, the smallest first; the largest one below the first that does not fit."""
    best, failed = 0, False
    for number in sorted(numbers):
        failed = not await fits(number) or failed
        best = best if failed else number
    return best

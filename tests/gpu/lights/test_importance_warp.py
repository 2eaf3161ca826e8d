import numpy as np
import pytest
import warp as wp

from gpu.lights.importance_warp import ImportanceWarp
from gpu.scene.types import Doubles, Ints

CPU = wp.get_device("cpu")
SEEDS = 2048


def halton(index: int, base: int) -> float:
    value, digit = 0.0, 1.0
    while index:
        digit /= base
        value, index = value + digit * (index % base), index // base
    return value


def seeds_of(importance: Doubles, side: int, seed: int = 0) -> Ints:
    """The pixels of seeds by an image's importance, in Morton's order."""
    warp = ImportanceWarp(len(importance), side, CPU, seed)
    warp.importance.assign(importance.astype(np.float32))
    seeds = wp.zeros(SEEDS, dtype=int, device=CPU)
    warp.run(seeds)
    return np.asarray(seeds.numpy())


def warped(importance: Doubles, side: int, point: tuple[float, float]) -> int:
    """The pixel that a point goes to, quarter by quarter (Clarberg et al. 2005)."""
    whole = np.zeros(side * side)
    whole[: len(importance)] = importance
    x, y = point
    begin, size = 0, side * side
    while size > 1:
        size //= 4
        a, b, c, d = (whole[begin + q * size : begin + (q + 1) * size].sum() for q in range(4))
        upper = (a + b) / (a + b + c + d)
        row = int(y >= upper)
        y = (y - upper) / (1 - upper) if row else y / upper
        share = c / (c + d) if row else a / (a + b)
        column = int(x >= share)
        x = (x - share) / (1 - share) if column else x / share
        begin += (2 * row + column) * size
    return begin


def test_seeds_go_where_a_plain_warp_takes_them() -> None:
    rng = np.random.default_rng(0)
    importance = rng.uniform(0.0, 1.0, 2 * 256) ** 4  # two maps of the four that an atlas has room for
    found = seeds_of(importance, 32)
    points = [(halton(number, 2), halton(number, 3)) for number in range(1, SEEDS + 1)]
    expected = [warped(importance, 32, point) for point in points]
    # In float32 a seed at the edge of a pixel may fall into the next.
    assert (found == expected).mean() > 0.99


def test_seeds_are_as_many_as_pixels_are_important() -> None:
    importance = np.ones(1024)
    importance[:256] = 5.0
    importance[512:] = 0.0
    found = seeds_of(importance, 32)
    assert found.max() < 512
    assert (found < 256).mean() == pytest.approx(5.0 / 6.0, abs=0.005)
    # Evenly, too: no pixel of the same importance has far more than another.
    assert np.ptp(np.bincount(found, minlength=512)[:256]) <= 8  # at random it is 14


def test_other_seeds_have_other_places_that_are_as_even() -> None:
    first, again, other = (seeds_of(np.ones(1024), 32, seed) for seed in (7, 7, 8))
    assert np.array_equal(first, again)
    assert (first == other).mean() < 0.02
    assert np.ptp(np.bincount(first, minlength=1024)) <= 4


def test_nothing_important_has_no_seeds() -> None:
    assert (seeds_of(np.zeros(1024), 32) == -1).all()

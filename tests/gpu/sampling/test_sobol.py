"""Sobol pairs: how evenly they lie, at once and over time, and that pixels are independent."""

import numpy as np
import pytest
import warp as wp
from scenes import results
from scipy import stats

from gpu.sampling.sobol import pixel_seed, sobol_pair, sobol_pair_at

COUNT = 1 << 14


@wp.kernel
def sobol_kernel(first: int, pair: int, seed: int, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    point = sobol_pair(index, pair, seed)
    out[index] = wp.vec2(point.x, point.y)


@wp.kernel
def place_kernel(first: int, first_place: int, places: int, first_moment: int, pair: int, seed: int,
                 out: wp.array[wp.vec2]) -> None:  # fmt: skip
    """One thread a sample: that of a place, and of a moment once all places have one."""
    index = first + wp.tid()
    point = sobol_pair_at(first_place + index % places, first_moment + index // places, pair, seed)
    out[index] = wp.vec2(point.x, point.y)


@wp.kernel
def independent_kernel(first: int, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 7))
    out[index] = wp.vec2(point.x, point.y)


def test_every_power_of_two_of_points_is_stratified() -> None:
    for pair, seed in ((0, 0), (1, 0), (5, 123)):
        points = results(sobol_kernel, 256, [pair, seed], wp.vec2)
        for columns in (1, 2, 4, 8, 16, 32, 64, 128, 256):
            cells = np.floor(points * (columns, 256 // columns)).astype(int)
            assert len(np.unique(cells, axis=0)) == 256, (pair, seed, columns)


@pytest.mark.parametrize(("place", "places", "moment"), [(256, 256, 3), (77, 1, 256)])
def test_places_of_a_moment_and_moments_of_a_place_are_stratified(place: int, places: int, moment: int) -> None:
    for pair, seed in ((0, 0), (1, 0), (5, 123)):
        points = results(place_kernel, 256, [place, places, moment, pair, seed], wp.vec2)
        for columns in (1, 2, 4, 8, 16, 32, 64, 128, 256):
            cells = np.floor(points * (columns, 256 // columns)).astype(int)
            assert len(np.unique(cells, axis=0)) == 256, (pair, seed, columns)


def test_pairs_and_seeds_give_different_points() -> None:
    sets = [results(sobol_kernel, 64, [pair, seed], wp.vec2) for pair, seed in ((0, 0), (1, 0), (0, 1))]
    for number, points in enumerate(sets):
        for other in sets[number + 1 :]:
            assert np.abs(np.sort(points[:, 0]) - np.sort(other[:, 0])).max() > 0.0
            assert abs(np.corrcoef(points[:, 0], other[:, 0])[0, 1]) < 0.4


def test_same_seed_gives_the_same_bits() -> None:
    assert np.array_equal(*(results(sobol_kernel, 4096, [3, 9], wp.vec2) for _ in range(2)))


def test_pixels_are_uniform_and_independent() -> None:
    points = results(independent_kernel, COUNT, [], wp.vec2)
    cells = np.histogram2d(points[:, 0], points[:, 1], 16, [[0, 1], [0, 1]])[0]
    assert stats.chisquare(cells.ravel()).pvalue > 1e-3
    assert abs(np.corrcoef(points[:-1, 0], points[1:, 0])[0, 1]) < 0.03

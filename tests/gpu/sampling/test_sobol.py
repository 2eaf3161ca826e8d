"""Sampled frequencies against the densities that the functions promise."""

from collections.abc import Callable

import numpy as np
import pytest
import warp as wp
from scenes import results
from scipy import stats

from gpu.core.morton import morton_2d
from gpu.sampling.sobol import pixel_seed, sobol_pair, sobol_pair_at
from gpu.sampling.warps import cone_direction, cosine_direction, orthonormal, sky_direction, triangle_barycentrics
from gpu.scene.types import Doubles

COUNT = 1 << 14
AXIS = wp.constant(wp.vec3(0.48, -0.6, 0.64))
CONE = wp.constant(0.7)
COSINE, IN_CONE, FROM_SKY = wp.constant(0), wp.constant(1), wp.constant(2)


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


@wp.kernel
def direction_kernel(first: int, mapping: int, axis: wp.vec3, out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 11))
    if mapping == COSINE:
        out[index] = cosine_direction(axis, point.x, point.y)
    elif mapping == IN_CONE:
        out[index] = cone_direction(axis, CONE, point.x, point.y)
    else:
        out[index] = sky_direction(point.x, point.y)


@wp.kernel
def triangle_kernel(first: int, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 13))
    out[index] = triangle_barycentrics(point.x, point.y)


@wp.kernel
def frame_kernel(first: int, normals: wp.array[wp.vec3], out: wp.array[wp.mat33]) -> None:
    index = first + wp.tid()
    out[index] = orthonormal(normals[index])


@wp.kernel
def z_order_kernel(first: int, width: int, out: wp.array[int]) -> None:
    index = first + wp.tid()
    out[index] = morton_2d(index % width, index // width)


def uniform(values: Doubles, bins: int = 64) -> float:
    """p-value of the χ² test that `values` in [0, 1] are uniform."""
    return float(stats.chisquare(np.histogram(values, bins, (0.0, 1.0))[0]).pvalue)


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


@pytest.mark.parametrize(
    ("mapping", "cumulative"),
    [
        (int(COSINE), lambda h: h * h),
        (int(IN_CONE), lambda h: (h - float(CONE)) / (1.0 - float(CONE))),
        (int(FROM_SKY), lambda h: (1.0 + h) ** 2 / 4.0),
    ],
    ids=["cosine", "cone", "sky"],
)
def test_directions_have_their_density(mapping: int, cumulative: Callable[[Doubles], Doubles]) -> None:
    axis = np.array([0.0, 1.0, 0.0]) if mapping == int(FROM_SKY) else np.array(tuple(AXIS))
    directions = results(direction_kernel, COUNT, [mapping, wp.vec3(*axis)], wp.vec3)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-5)
    heights = directions @ axis
    tangent = np.cross(axis, (1.0, 0.0, 0.0))
    tangent /= np.linalg.norm(tangent)
    angle = np.arctan2(directions @ np.cross(axis, tangent), directions @ tangent)
    assert uniform(np.clip(cumulative(heights), 0.0, 1.0)) > 1e-3
    assert uniform(angle / (2.0 * np.pi) + 0.5) > 1e-3


def test_triangles_are_covered_uniformly() -> None:
    u, v = results(triangle_kernel, COUNT, [], wp.vec2).T
    assert (u >= 0.0).all()
    assert (v >= 0.0).all()
    assert (u + v <= 1.0 + 1e-6).all()
    assert uniform(1.0 - (1.0 - u) ** 2) > 1e-3
    assert uniform(1.0 - (1.0 - v) ** 2) > 1e-3
    assert uniform((u + v) ** 2) > 1e-3


def test_frames_are_orthonormal_and_right_handed() -> None:
    normals = np.random.default_rng(0).normal(size=(500, 3))
    normals[:4] = [[0, 0, 1], [0, 0, -1], [1e-4, 0, -1], [1, 0, 0]]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    frames = results(frame_kernel, 500, [wp.array(normals, dtype=wp.vec3, device="cpu")], wp.mat33)
    assert np.allclose(np.transpose(frames, (0, 2, 1)) @ frames, np.eye(3), atol=1e-5)
    assert np.allclose(frames[:, :, 2], normals, atol=1e-6)
    assert np.allclose(np.linalg.det(frames), 1.0, atol=1e-5)


def test_z_order_numbers_each_block_in_turn() -> None:
    numbers = results(z_order_kernel, 64, [8], int).reshape(8, 8)
    assert sorted(numbers.ravel()) == list(range(64))
    assert numbers[:2, :2].tolist() == [[0, 1], [2, 3]]
    assert numbers[4:, 4:].min() == 48

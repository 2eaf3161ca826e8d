"""Mappings of uniform samples: their frequencies against the densities that they promise."""

from collections.abc import Callable

import numpy as np
import pytest
import warp as wp
from scenes import results
from scipy import stats

from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import (
    cone_direction,
    cosine_direction,
    on_disk,
    orthonormal,
    sky_direction,
    triangle_barycentrics,
)
from gpu.scene.types import Doubles

COUNT = 1 << 14
AXIS = wp.constant(wp.vec3(0.48, -0.6, 0.64))
CONE = wp.constant(0.7)
COSINE, IN_CONE, FROM_SKY = wp.constant(0), wp.constant(1), wp.constant(2)


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
def disk_kernel(first: int, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 17))
    out[index] = on_disk(point.x, point.y)


def uniform(values: Doubles, bins: int = 64) -> float:
    """p-value of the χ² test that `values` in [0, 1] are uniform."""
    return float(stats.chisquare(np.histogram(values, bins, (0.0, 1.0))[0]).pvalue)


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


def test_the_disk_is_covered_uniformly() -> None:
    x, y = results(disk_kernel, COUNT, [], wp.vec2).T
    assert uniform(x * x + y * y) > 1e-3
    assert uniform(np.arctan2(y, x) / (2.0 * np.pi) + 0.5) > 1e-3

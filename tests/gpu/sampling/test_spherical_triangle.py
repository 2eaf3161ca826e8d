import numpy as np
import pytest
import warp as wp
from scenes import results
from scipy import stats

from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.spherical_triangle import Corners, triangle_direction, triangle_solid_angle
from gpu.scene.types import Doubles

COUNT = 1 << 14


@wp.kernel
def solid_angle_kernel(first: int, corners: Corners, out: wp.array[float]) -> None:
    out[first + wp.tid()] = triangle_solid_angle(corners)


@wp.kernel
def direction_kernel(first: int, corners: Corners, out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 5))
    out[index] = triangle_direction(corners, triangle_solid_angle(corners), point.x, point.y)


def corners_of(a: Doubles, b: Doubles, c: Doubles) -> Corners:
    corners = Corners()
    corners.a, corners.b, corners.c = (wp.vec3(*(v / np.linalg.norm(v))) for v in (a, b, c))
    return corners


def solid_angle(*corners: Doubles) -> float:
    return float(results(solid_angle_kernel, 1, [corners_of(*corners)], float)[0])


def test_an_octant_has_half_pi_and_is_negative_from_behind() -> None:
    x, y, z = np.eye(3)
    assert solid_angle(x, z, y) == pytest.approx(np.pi / 2.0, rel=1e-5)
    assert solid_angle(x, y, z) == pytest.approx(-np.pi / 2.0, rel=1e-5)


def test_far_triangles_have_area_over_squared_distance() -> None:
    a, b, c = np.array([[0.0, 0.0, -5.0], [0.1, 0.0, -5.0], [0.0, 0.1, -5.0]])
    assert solid_angle(a, b, c) == pytest.approx(0.005 / 25.0, rel=1e-2)


def test_directions_are_uniform_in_an_octant() -> None:
    x, y, z = np.eye(3)
    directions = results(direction_kernel, COUNT, [corners_of(x, z, y)], wp.vec3)
    assert (directions >= -1e-5).all()
    azimuth = np.arctan2(directions[:, 1], directions[:, 0]) / (np.pi / 2.0)
    cells = np.histogram2d(np.clip(directions[:, 2], 0, 1), np.clip(azimuth, 0, 1), 12, [[0, 1], [0, 1]])[0]
    assert stats.chisquare(cells.ravel()).pvalue > 1e-3


def test_directions_are_uniform_in_an_oblique_triangle() -> None:
    a, b, c = (
        v / np.linalg.norm(v)
        for v in (np.array([1.0, 0.2, -0.3]), np.array([0.1, -0.9, 0.5]), np.array([-0.6, 0.7, 1.0]))
    )
    assert solid_angle(a, b, c) > 2.0
    directions = results(direction_kernel, COUNT, [corners_of(a, b, c)], wp.vec3)
    ab, bc, ca = a + b, b + c, c + a
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    inside = [(np.linalg.inv(np.stack(part, axis=1)) @ directions.T >= 0.0).all(axis=0).sum() for part in parts]
    assert sum(inside) == pytest.approx(COUNT, abs=4)
    expected = np.array([solid_angle(*part) for part in parts])
    assert stats.chisquare(inside, expected * sum(inside) / expected.sum()).pvalue > 1e-3

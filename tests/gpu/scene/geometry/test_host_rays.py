import numpy as np
import pytest

from gpu.scene.geometry.host_rays import HostRays

# Two squares across z, one at 0 that faces +z, one at −1 that faces −z.
VERTICES = np.array(
    [[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, -1], [-1, 1, -1], [1, 1, -1], [1, -1, -1]]
)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def rays() -> HostRays:
    return HostRays(VERTICES, TRIANGLES)


def test_the_first_triangle_is_met_at_its_distance(rays: HostRays) -> None:
    distance, face = rays.first(np.array([0.5, 0.2, 2.0]), DOWN)
    assert (distance, face // 2) == (pytest.approx(2.0), 0)
    slanted = np.array([0.6, 0.0, -0.8])
    distance, face = rays.first(np.array([0.0, 0.0, 0.8]), slanted)
    assert (distance, face // 2) == (pytest.approx(1.0), 0)


def test_triangles_behind_or_beside_are_not_met(rays: HostRays) -> None:
    assert rays.first(np.array([0.0, 0.0, 0.5]), -DOWN) == (float("inf"), -1)
    assert rays.first(np.array([1.5, 0.0, 0.5]), DOWN) == (float("inf"), -1)
    distance, face = rays.first(np.array([0.1, 0.3, 0.0]), DOWN)  # starts on one
    assert (distance, face // 2) == (pytest.approx(1.0), 1)


def test_backs_are_culled_where_asked(rays: HostRays) -> None:
    below = np.array([0.5, 0.2, -3.0])
    assert rays.first(below, -DOWN, np.ones(4, bool))[0] == pytest.approx(2.0)
    assert rays.first(np.array([0.5, 0.2, -0.5]), -DOWN, np.ones(4, bool))[1] == -1
    assert rays.first(np.array([0.5, 0.2, -0.5]), -DOWN, np.zeros(4, bool))[0] == pytest.approx(0.5)


def test_against_every_triangle() -> None:
    rng = np.random.default_rng(1)
    vertices = rng.uniform(-0.5, 0.5, (300, 3))
    triangles = np.arange(300).reshape(-1, 3)
    tested = HostRays(vertices, triangles)
    for _ in range(50):
        origin, way = rng.uniform(-1.0, 1.0, (2, 3))
        way /= np.linalg.norm(way)
        best = np.inf
        for a, b, c in vertices[triangles]:
            u, v, t = np.linalg.solve(np.stack([b - a, c - a, -way], axis=1), origin - a)
            if min(u, v) > 0.0 and u + v < 1.0 and t > 0.0:
                best = min(best, t)
        assert tested.first(origin, way)[0] == pytest.approx(best)

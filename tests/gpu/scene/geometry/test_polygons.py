"""Polygons as triangles: the area of any outline, its orientation, and what is said of those that cross."""

import numpy as np
import pytest

from gpu.scene.geometry.normals import area_vectors
from gpu.scene.geometry.polygons import MOST_CORNERS, Triangulation, triangulate

EAR = np.array([0, 1, 2], np.uint32)
U = [(-2, 2), (2, 2), (2, -2), (1, -2), (1, 1), (-1, 1), (-1, -2), (-2, -2)]
ARROW = [(0, 0), (4, 0), (1, 1), (0, 4)]
DISC = [(np.cos(angle), np.sin(angle)) for angle in np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False)]
SAW = [*((x, (x % 2) * 0.5) for x in range(3000)), (3000, -1), (0, -1)]


def tilted(outline: list[tuple[float, float]]) -> np.ndarray:
    """An outline (corner, 2) in a plane of space that no axis is in, far from the origin."""
    axes, _ = np.linalg.qr(np.array([[1.0, 2.0, 3.0], [2.0, 0.5, 1.0], [0.3, 1.0, 0.2]]))
    return np.pad(np.array(outline, float), ((0, 0), (0, 1))) @ axes.T + 1000.0


def cut(positions: np.ndarray) -> Triangulation:
    return triangulate(positions, np.arange(len(positions)), np.array([len(positions)]))


def area(positions: np.ndarray, found: Triangulation) -> float:
    """That which the triangles cover, all of them looking to the outline's side."""
    normals = area_vectors(positions, found.triangles) / 2.0
    spokes = positions - positions[0]
    side = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    assert (normals @ side >= -1e-9).all()
    return float(np.linalg.norm(normals, axis=1).sum())


@pytest.mark.parametrize(
    ("outline", "expected"),
    [
        (U, 10.0),
        (U[::-1], 10.0),
        (U[3:] + U[:3], 10.0),
        (ARROW, 4.0),
        (ARROW[1:] + ARROW[:1], 4.0),
        ([(0, 0), (1, 0), (2, 0), (2, 2), (2, 2), (0, 2), (0, 1)], 4.0),  # on a line, and twice the same
        ([(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)], 12.0),  # round a hole
        (DISC, np.pi),
        (SAW, 3749.5),
    ],
)
def test_any_flat_outline_is_covered_once(outline: list[tuple[float, float]], expected: float) -> None:
    positions = tilted(outline)
    found = cut(positions)
    assert area(positions, found) == pytest.approx(expected, rel=1e-4)
    assert found.crossing == 0


def test_an_outline_that_is_nearly_flat_keeps_its_shape() -> None:
    positions = tilted(U) + np.random.default_rng(1).uniform(-0.01, 0.01, (len(U), 3))
    found = cut(positions)
    assert area(positions, found) == pytest.approx(10.0, rel=0.02)
    assert found.crossing == 0


@pytest.mark.parametrize(
    "outline",
    [
        [(0, 0), (1, 1), (1, 0), (0, 1)],
        [(np.cos(angle), np.sin(angle)) for angle in np.arange(5) * 0.8 * np.pi],
        [(0, 0), (2, 2), (2, 0), (0, 2), (-1, 1)],
    ],
)
def test_outlines_that_cross_themselves_are_counted(outline: list[tuple[float, float]]) -> None:
    assert cut(tilted(outline)).crossing == 1


@pytest.mark.parametrize("order", [[0, 0, 0, 0, 0], [0, 1, 3, 2], [0, 1, 2, 5, 3]])
def test_outlines_without_an_area_become_triangles_without(order: list[int]) -> None:
    positions = np.array([(x, 0.0, 0.0) for x in order])
    found = cut(positions)
    assert (len(found.triangles) > 0, found.crossing) == (True, 0)
    assert area(positions, found) == 0.0


def test_triangles_keep_the_order_of_their_polygons() -> None:
    positions = tilted([*ARROW, (9, 9), (10, 9), (9, 10)])
    corners = np.array([4, 5, 6, 0, 1, 2, 3, 6, 5, 4, 0, 1])
    found = triangulate(positions, corners, np.array([3, 4, 2, 3]))
    assert found.polygons.tolist() == [0, 1, 1, 3]
    assert (found.triangles[0].tolist(), found.triangles[3].tolist()) == ([0, 1, 2], [9, 10, 11])
    assert found.too_small == 1


def test_no_polygons_are_no_triangles() -> None:
    found = triangulate(np.empty((0, 3)), np.empty(0, np.int64), np.empty(0, np.int64))
    assert (found.triangles.shape, found.polygons.shape) == ((0, 3), (0,))


@pytest.mark.parametrize(("corners", "left_out"), [(MOST_CORNERS, 0), (MOST_CORNERS + 1, 1)])
def test_a_polygon_that_would_take_too_long_is_left_out(
    corners: int, left_out: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not a convex one, which is quickly cut however many corners it has."""
    cut_ears = []
    monkeypatch.setattr(
        "gpu.scene.geometry.polygons.mapbox_earcut.triangulate_float64", lambda *_: cut_ears.append(1) or EAR
    )
    wave = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    disc = np.stack([np.cos(wave), np.sin(wave), 0.0 * wave], axis=1)
    teeth = disc * np.where(np.arange(corners) % 2, 1.0, 0.5)[:, None]
    positions = np.concatenate([teeth, disc])
    found = triangulate(positions, np.arange(2 * corners), np.array([corners, corners]))
    assert (found.too_large, len(cut_ears)) == (left_out, 1 - left_out)
    assert np.count_nonzero(found.polygons == 1) == corners - 2

"""Walls keep their openings open, and what fills them faces into the room."""

import numpy as np
import pytest

from gpu.scene.builtin import rooms
from gpu.scene.builtin.rooms import LAP, Opening
from gpu.scene.builtin.shape import Shape

HOLES = [Opening(1.0, 0.8, 2.5, 2.0), Opening(3.0, 0.8, 4.0, 2.0)]


def areas(shape: Shape) -> np.ndarray:
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a) / 2.0


def test_a_wall_leaves_its_openings_free() -> None:
    shape = rooms.wall(5.0, 2.5, HOLES, 0.2)
    face = areas(shape)[:, 2].sum()
    assert face == pytest.approx((5.0 + 2 * LAP) * 2.5 - sum(hole.width * hole.height for hole in HOLES))
    centres = shape.positions[shape.triangles].mean(axis=1)
    centres = centres[np.abs(centres[:, 2]) < 1e-9]
    for hole in HOLES:
        within = (centres[:, 0] > hole.left) & (centres[:, 0] < hole.right) & (centres[:, 1] > hole.bottom)
        inside = within & (centres[:, 1] < hole.top)
        assert not inside.any()


def test_an_opening_is_lined_towards_its_middle() -> None:
    shape = rooms.wall(5.0, 2.5, HOLES[:1], 0.2)
    hole = HOLES[0]
    middle = np.array([(hole.left + hole.right) / 2, (hole.bottom + hole.top) / 2, -0.1])
    normals = areas(shape)
    lining = np.abs(normals[:, 2]) < 1e-12
    assert lining.sum() == 8
    centres = shape.positions[shape.triangles].mean(axis=1)
    assert (np.einsum("tc,tc->t", normals, middle - centres)[lining] > 0.0).all()


def test_bands_cover_the_pane_and_face_inwards() -> None:
    x = np.linspace(0.0, 1.0, 17)
    parts = rooms.bands(HOLES[0], 0.2, [0.3 + 0.1 * np.sin(6 * x), 0.6 + 0.1 * np.cos(9 * x)])
    assert len(parts) == 3
    total = sum(areas(part).sum(axis=0) for part in parts)
    np.testing.assert_allclose(total, areas(rooms.bands(HOLES[0], 0.2, [])[0]).sum(axis=0), atol=1e-12)
    assert total[2] > 0.0


def test_a_blind_fits_its_window() -> None:
    hole = HOLES[0]
    for part in rooms.venetian_blind(hole, -0.1, 30.0):
        assert (part.positions[:, 0] > hole.left).all()
        assert (part.positions[:, 0] < hole.right).all()
        assert (part.positions[:, 1] > hole.bottom).all()
        assert (part.positions[:, 1] < hole.top).all()


def test_a_floor_faces_up_past_the_walls() -> None:
    floor = rooms.level(2.0, 3.0, 0.5)
    np.testing.assert_allclose(areas(floor).sum(axis=0), (0.0, (4 + 2 * LAP) * (6 + 2 * LAP), 0.0), atol=1e-12)
    assert (floor.positions[:, 1] == 0.5).all()

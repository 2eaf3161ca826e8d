"""Shapes are closed, face outwards, have the size they say, and keep fronts through every change."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
from shape_checks import agreement, volume

from gpu.scene.builtin.shape import Shape
from gpu.scene.builtin.shapes import (
    block,
    box,
    cylinder,
    lathe,
    moulding,
    picture,
    quad,
    rectangle,
    slab,
    sphere,
    superellipse,
    tube,
)

SOLIDS: dict[str, tuple[Callable[[], Shape], float]] = {
    "sharp box": (lambda: box((2.0, 3.0, 4.0), 0.0), 24.0),
    "rounded box": (lambda: box((1.0, 1.0, 1.0), 0.05, 3), 0.993),
    "block": (lambda: block((1.0, 2.0, 3.0), (2.0, 4.0, 6.0)), 6.0),
    "cylinder": (lambda: cylinder(0.5, 2.0, 96), pi * 0.5),
    "sphere": (lambda: sphere(1.0, 96), 4.0 / 3.0 * pi),
    "bar": (lambda: tube([(0, 0, 0), (0, 0, 1.0), (0, 0, 3.0)], 0.1, 64), 3.0 * pi * 0.01),
    "slab": (lambda: slab(superellipse(1.0, 0.5, 2.0, 256), 0.2), pi * 0.5 * 0.2),
    "bevelled slab": (lambda: slab(superellipse(1.0, 1.0, 2.0, 256), 0.2, 0.01), pi * 0.2),
    "moulding": (lambda: moulding([(0, 0), (0, 1), (0.1, 1), (0.1, 0)], rectangle((-1, -1), (1, 1))), 4 * 1.9 * 0.1),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_encloses_its_volume(name: str) -> None:
    make, expected = SOLIDS[name]
    shape = make()
    assert volume(shape) == pytest.approx(expected, rel=0.03)
    assert agreement(shape) > 0.4


def test_a_block_is_a_box_without_bevels() -> None:
    shape, other = block((1.0, 2.0, 3.0), (1.5, 4.0, 7.0)), box((0.5, 2.0, 4.0), 0.0).moved(1.25, 3.0, 5.0)
    for field in ("positions", "triangles", "normals", "uvs"):
        np.testing.assert_array_equal(getattr(shape, field), getattr(other, field))


def test_a_bevelled_box_keeps_its_flats_flat_and_its_size() -> None:
    shape = box((1.0, 0.5, 2.0), 0.02, 2)
    np.testing.assert_allclose(np.ptp(shape.positions, axis=0), (1.0, 0.5, 2.0))
    top = shape.positions[:, 1] > 0.25 - 1e-9
    flat = top & (np.abs(shape.positions[:, 0]) < 0.47) & (np.abs(shape.positions[:, 2]) < 0.97)
    corners = top & ~flat
    assert corners.any()
    assert (shape.normals[corners, 1] > 0.99).all()


def test_uvs_are_metres_and_a_picture_shows_its_texture_upright() -> None:
    wall = quad((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    np.testing.assert_allclose(np.ptp(wall.uvs, axis=0), (3.0, 2.0))
    np.testing.assert_allclose(wall.normals, np.broadcast_to((0.0, 0.0, 1.0), (4, 3)), atol=1e-12)
    canvas = picture(0.8, 0.6)
    top_left = np.argmin(canvas.positions @ (1.0, -1.0, 0.0))
    np.testing.assert_allclose(canvas.uvs[top_left], (0.0, 0.0), atol=1e-12)
    assert (canvas.normals[:, 2] > 0.99).all()


def test_a_lathe_without_an_end_is_an_open_surface_of_one_radius() -> None:
    pipe = lathe([(0.5, 0.0), (0.5, 1.0)], 24)
    np.testing.assert_allclose(np.linalg.norm(pipe.positions[:, [0, 2]], axis=1), 0.5)
    assert len(pipe.triangles) == 48

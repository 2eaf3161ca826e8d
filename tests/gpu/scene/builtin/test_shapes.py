"""Shapes are closed, face outwards, have the size they say, and keep fronts through every change."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest

from gpu.scene.builtin import furnishings, orders, seating
from gpu.scene.builtin.shape import Shape, join
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


def volume(shape: Shape) -> float:
    """The volume that the fronts enclose (divergence theorem): negative when they face inwards."""
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    return float(np.einsum("tc,tc->t", a, np.cross(b, c)).sum() / 6.0)


def agreement(shape: Shape) -> float:
    """The least cosine between a face's normal and those of its corners."""
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    faces = np.cross(b - a, c - a)
    faces /= np.linalg.norm(faces, axis=1)[:, None]
    return float(np.einsum("tkc,tc->tk", shape.normals[shape.triangles], faces).min())


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


@pytest.mark.parametrize(
    "make",
    [
        lambda: furnishings.cushion(0.5),
        lambda: furnishings.mug(0.04, 0.095),
        furnishings.saucer,
        lambda: furnishings.vase(0.1, 0.3),
        lambda: furnishings.bowl_of_fruit(1)[0],
        lambda: furnishings.bowl_of_fruit(1)[2],
        lambda: seating.pouf(0.3, 0.4),
        lambda: seating.sofa(2.0, 3)[0],
        lambda: orders.column(3.2, 0.2),
        lambda: orders.fountain(1.3)[0],
        orders.baluster,
        lambda: orders.arch(2.4, 1.75, 0.36)[1],
    ],
)
def test_furniture_faces_outwards(make: Callable[[], Shape]) -> None:
    assert volume(make()) > 0.0


def test_a_bevelled_box_keeps_its_flats_flat_and_its_size() -> None:
    shape = box((1.0, 0.5, 2.0), 0.02, 2)
    np.testing.assert_allclose(np.ptp(shape.positions, axis=0), (1.0, 0.5, 2.0))
    top = shape.positions[:, 1] > 0.25 - 1e-9
    flat = top & (np.abs(shape.positions[:, 0]) < 0.47) & (np.abs(shape.positions[:, 2]) < 0.97)
    corners = top & ~flat
    assert corners.any()
    assert (shape.normals[corners, 1] > 0.99).all()


def test_creases_split_normals_and_smooth_parts_share_them() -> None:
    sharp, smooth = box((1.0, 1.0, 1.0), 0.0), sphere(1.0, 64)
    assert set(np.unique(np.round(np.abs(sharp.normals), 6))) == {0.0, 1.0}
    outwards = smooth.positions / np.linalg.norm(smooth.positions, axis=1)[:, None]
    assert np.einsum("vc,vc->v", outwards, smooth.normals).min() > 0.999


@pytest.mark.parametrize(
    "change",
    [
        lambda shape: shape.mirrored(0),
        lambda shape: shape.mirrored(1).turned(33.0, "z"),
        lambda shape: shape.turned(200.0, "x").moved(1.0, 2.0, 3.0),
        lambda shape: shape.at((0.0, 5.0, 0.0)),
        lambda shape: shape.at([(1.0, 0.0, 2.0)], 70.0),
    ],
)
def test_changes_of_place_keep_volume_and_normals(change: Callable[[Shape], Shape]) -> None:
    shape = cylinder(0.3, 0.7, 24, 0.01)
    changed = change(shape)
    assert volume(changed) == pytest.approx(volume(shape))
    assert agreement(changed) == pytest.approx(agreement(shape))


def test_turns_go_counter_clockwise() -> None:
    point = quad((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    np.testing.assert_allclose(point.turned(90.0, "y").positions[0], (0.0, 0.0, -1.0), atol=1e-12)
    np.testing.assert_allclose(point.turned(90.0, "z").positions[0], (0.0, 1.0, 0.0), atol=1e-12)


def test_copies_are_whole_and_apart() -> None:
    shape = box((0.1, 0.1, 0.1), 0.0)
    row = shape.at([(x, 0.0, 0.0) for x in range(5)], uv_shifts=[(x, 0.0) for x in range(5)])
    assert volume(row) == pytest.approx(5 * volume(shape))
    assert len(row.positions) == 5 * len(shape.positions)
    np.testing.assert_allclose(row.uvs[-len(shape.uvs) :], shape.uvs + np.array([4.0, 0.0]))
    np.testing.assert_array_equal(join([shape, shape]).triangles[len(shape.triangles) :], shape.triangles + 24)


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

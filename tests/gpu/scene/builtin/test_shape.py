"""Shapes keep their fronts and volume through every change, and their creases."""

from collections.abc import Callable

import numpy as np
import pytest
from shape_checks import agreement, volume

from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import (
    box,
    cylinder,
    quad,
    sphere,
)


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

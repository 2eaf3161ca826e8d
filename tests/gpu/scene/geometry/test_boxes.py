"""Columns of three numbers at a time, against numpy along the axis of three."""

import numpy as np

from gpu.scene.geometry.boxes import box, largest, lengths, middles

RANDOM = np.random.default_rng(7)
POSITIONS = RANDOM.normal(size=(20, 3))
TRIANGLES = RANDOM.integers(0, 10, (12, 3))


def test_a_box_is_that_of_the_corners_that_are_used() -> None:
    low, high = box(POSITIONS, TRIANGLES)
    corners = POSITIONS[TRIANGLES].reshape(-1, 3)
    assert np.array_equal([low, high], [corners.min(axis=0), corners.max(axis=0)])


def test_largest_lengths_and_middles() -> None:
    assert np.array_equal(largest(POSITIONS), np.abs(POSITIONS).max(axis=1))
    assert np.allclose(lengths(POSITIONS), np.linalg.norm(POSITIONS, axis=1))
    assert np.allclose(middles(POSITIONS, TRIANGLES), POSITIONS[TRIANGLES].mean(axis=1))

"""Boxes around triangles, and what else is found of many rows of three numbers, a column at a time: numpy is several
times slower along an axis of three.
"""

import numpy as np

from gpu.scene.types import Doubles, Floats, Integers


def box(positions: Doubles, triangles: Integers) -> tuple[Doubles, Doubles]:
    """The least and largest coordinates (3,) of the corners of triangles (triangle, 3), at least one."""
    columns = [positions[:, axis][triangles] for axis in range(3)]
    return np.array([column.min() for column in columns]), np.array([column.max() for column in columns])


def largest(rows: Doubles | Floats) -> Doubles:
    """The largest absolute number (row,) in each of `rows` (row, 3)."""
    x, y, z = (np.abs(rows[:, axis]) for axis in range(3))
    return np.asarray(np.maximum(np.maximum(x, y), z), np.float64)


def lengths(rows: Doubles) -> Doubles:
    """The Euclidean lengths (row,) of `rows` (row, 3)."""
    return np.asarray(np.sqrt(np.einsum("rc,rc->r", rows, rows)))


def middles(positions: Doubles, triangles: Integers) -> Doubles:
    """The centroids (triangle, 3) of triangles (triangle, 3), indices of positions (vertex, 3)."""
    a, b, c = (positions.take(triangles[:, corner], axis=0) for corner in range(3))
    return np.asarray((a + b + c) / 3.0)

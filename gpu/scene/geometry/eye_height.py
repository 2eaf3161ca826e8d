"""Where a person could stand: floors, and eyes above them."""

from collections.abc import Iterable

import numpy as np

from gpu.scene.geometry.boxes import lengths
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.types import Doubles, Integers, Mask

EYE_HEIGHT = 1.6
"""Of a standing person's eyes above the floor [m]."""
HEADROOM = 1.9
"""What is free above a floor that a person stands on [m]."""
_LEVEL = 0.8  # cosine of the steepest floor
_SAME_FLOOR = 0.15  # what is no higher or lower belongs to one floor [m]
_EDGES = ((1, 2), (2, 0), (0, 1))
_FLOOR = 0.25  # of the area of the largest floor; less is a table or a shelf


def standing_eyes(
    columns: Iterable[tuple[float, float]], vertices: Doubles, triangles: Integers, metre: float
) -> Doubles:
    """Eyes (eye, 3) of people who stand on the floors of a scene, upright in `columns`, which are given by x and z.

    vertices (vertex, 3), +Y up; metre: its length in their unit.
    """
    faces = area_vectors(vertices, triangles)
    level = faces[:, 1] > _LEVEL * lengths(faces)
    middles, areas = vertices[triangles[level], 1].mean(axis=1), faces[level, 1]
    around = _bounds_from_above(vertices, triangles)
    found: list[tuple[float, float, float]] = []
    for x, z in columns:
        below = triangles[_inside(around, x, z)]
        heights, upwards = _crossed(x, z, vertices, below)
        free = np.diff(heights, append=np.inf) >= HEADROOM * metre
        found += [(x, float(height), z) for height in heights[upwards & free]]
    if not found:
        return np.zeros((0, 3))
    floors = np.array(found)
    extent = np.array([areas[np.abs(middles - y) < _SAME_FLOOR * metre].sum() for y in floors[:, 1]])
    eyes: Doubles = floors[extent >= _FLOOR * extent.max()] + (0.0, EYE_HEIGHT * metre, 0.0)
    return eyes


def _bounds_from_above(vertices: Doubles, triangles: Integers) -> Doubles:
    """Least and largest x and z of each triangle, (4, triangle): x, x, z, z."""
    x, z = (vertices[triangles, axis] for axis in (0, 2))
    return np.stack([x.min(axis=1), x.max(axis=1), z.min(axis=1), z.max(axis=1)])


def _inside(around: Doubles, x: float, z: float) -> Mask:
    return np.asarray((around[0] <= x) & (x <= around[1]) & (around[2] <= z) & (z <= around[3]))


def _crossed(x: float, z: float, vertices: Doubles, triangles: Integers) -> tuple[Doubles, Mask]:
    """Heights, from below, at which a vertical line meets triangles, and whether each is a floor there."""
    corners = vertices[triangles] - (x, 0.0, z)
    faces = area_vectors(vertices, triangles)
    # Shares of the corners: areas, seen from above, of the triangles that the line makes with the edges.
    shares = np.stack([corners[:, b, 2] * corners[:, c, 0] - corners[:, b, 0] * corners[:, c, 2] for b, c in _EDGES])
    met = (shares * np.sign(faces[:, 1]) >= 0.0).all(axis=0) & (faces[:, 1] != 0.0)
    heights = np.einsum("ct,tc->t", shares[:, met], corners[met, :, 1]) / faces[met, 1]
    upwards = faces[met, 1] > _LEVEL * lengths(faces[met])
    order = np.argsort(heights)
    return heights[order], upwards[order]

"""A camera for a scene that has none: inside of a room, outside of an object."""

from itertools import product

import numpy as np

from gpu.camera import look_at
from gpu.scene.normals import area_vectors
from gpu.scene.types import Camera, Doubles, Floats, Integers, Placement

_SAMPLES = 20_000
_AZIMUTHS, _HEIGHTS = 16, 8
_ENCLOSED = 0.6  # share of the directions from a point in a room that end at a surface's front


def default_camera(vertices: Floats, triangles: Integers, placement: Placement) -> Camera:
    """A perspective view in world space of the unit-space triangles.

    Where surfaces face a point from most sides, the scene is a room: the camera stands at the end of its longest free
    line through that point. Otherwise it is an object, seen whole from above one corner.
    """
    points, normals = _surface_points(vertices.astype(np.float64), triangles)
    low, high = points.min(axis=0), points.max(axis=0)
    views = [_look_around(low + (high - low) * at, points, normals) for at in product((0.3, 0.5, 0.7), repeat=3)]
    enclosed, _, eye, target = max(views, key=lambda view: (view[0] >= _ENCLOSED, view[1]))
    if enclosed < _ENCLOSED:
        radius = float(np.linalg.norm(high - low)) / 2.0
        target = (low + high) / 2.0
        eye = target + np.array([0.5, 0.35, 0.8]) / np.linalg.norm([0.5, 0.35, 0.8]) * radius / np.sin(np.radians(30.0))
    world = [(point / placement.scale + placement.centre).tolist() for point in (eye, target)]
    return look_at(world[0], world[1], name="default")


def _surface_points(vertices: Doubles, triangles: Integers) -> tuple[Doubles, Doubles]:
    """Points spread evenly over all triangles, (sample, 3), and the geometric normals there."""
    faces = area_vectors(vertices, triangles)
    areas = np.linalg.norm(faces, axis=1)
    random = np.random.default_rng(0)
    chosen = np.searchsorted(np.cumsum(areas / areas.sum()), random.random(_SAMPLES)).clip(0, len(triangles) - 1)
    root, other = np.sqrt(random.random((_SAMPLES, 1))), random.random((_SAMPLES, 1))
    a, b, c = (vertices[triangles[chosen, corner]] for corner in range(3))
    return (1.0 - root) * a + root * (1.0 - other) * b + root * other * c, faces[chosen]


def _look_around(centre: Doubles, points: Doubles, normals: Doubles) -> tuple[float, float, Doubles, Doubles]:
    """What `centre` sees of `points`: share of directions closed by fronts, length of view, its eye and target."""
    offsets = points - centre
    distance = np.maximum(np.linalg.norm(offsets, axis=1), 1e-9)
    azimuth = ((np.arctan2(offsets[:, 2], offsets[:, 0]) / (2.0 * np.pi)) % 1.0 * _AZIMUTHS).astype(int) % _AZIMUTHS
    height = ((offsets[:, 1] / distance + 1.0) / 2.0 * _HEIGHTS).astype(int).clip(0, _HEIGHTS - 1)
    cell = azimuth * _HEIGHTS + height  # all cells have the same solid angle
    farthest_first = np.argsort(-distance)
    nearest = np.full(_AZIMUTHS * _HEIGHTS, -1)
    nearest[cell[farthest_first]] = farthest_first
    seen = nearest[nearest >= 0]
    fronts = np.einsum("sc,sc->s", offsets[seen], normals[seen]) < 0.0
    depth = np.where(nearest >= 0, distance[nearest], 0.0).reshape(_AZIMUTHS, _HEIGHTS)
    level = depth[:, _HEIGHTS // 2 - 1 : _HEIGHTS // 2 + 1].min(axis=1)
    line = level + np.roll(level, _AZIMUTHS // 2)
    ahead = int(np.argmax(line))
    angle = (ahead + 0.5) / _AZIMUTHS * 2.0 * np.pi
    forward = np.array([np.cos(angle), 0.0, np.sin(angle)])
    behind = level[(ahead + _AZIMUTHS // 2) % _AZIMUTHS]
    return (
        float(fronts.sum()) / len(nearest),
        float(line[ahead]),
        centre - 0.8 * behind * forward,
        centre + 0.5 * forward,
    )

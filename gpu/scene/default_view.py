"""A camera for a scene that has none: inside of a room, where a person would stand, outside of an object."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from gpu.scene.camera import look_at
from gpu.scene.geometry.boxes import lengths
from gpu.scene.geometry.eye_height import HEADROOM, standing_eyes
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.types import Camera, Doubles, Floats, Integers, Mask, Placement

_SAMPLES = 10_000
_AZIMUTHS, _HEIGHTS = 16, 8  # cells of equal solid angle around a point
_BESIDE = (np.arange(_AZIMUTHS) + np.arange(2, -3, -1)[:, None]) % _AZIMUTHS  # of each, as wide as the picture
_ALONG, _UP = (0.1, 0.3, 0.5, 0.7, 0.9), (0.3, 0.5, 0.7)  # where in the scene's box to stand
_ENCLOSED = 0.6  # share of the directions from a point in a room that end at a surface's front
_COVERED = 0.5  # and of those above the horizon: a lawn with a house on it is no room
_ROOM = 0.125  # share of such points in a room; beside a round object there are some too
_SMALL_ROOM = 0.6  # and where nobody could stand: between the pieces of an exhibit there are many
_NEAR = 1e-3
_INDOORS = 0.2  # covered of a place in a room, where some of what is above may be seen from behind, as lamps may
_TALLEST = 300.0  # of what people walk in [m]


@dataclass(frozen=True, eq=False)
class _Standpoint:
    """A point and what is seen from it: how enclosed and covered it is, how open all around and each way (azimuth,),
    and how far one sees each way at its height.
    """

    enclosed: float
    covered: float
    openness: float
    views: Doubles
    reach: Doubles
    eye: Doubles

    def view_of(self, other: "_Standpoint") -> float:
        """How open the view towards another point is, −∞ where it is not seen."""
        way = other.eye - self.eye
        ahead = int(_azimuth(way))
        return float(self.views[ahead]) if 0.0 < float(np.hypot(way[0], way[2])) < self.reach[ahead] else -np.inf


def default_camera(vertices: Floats, triangles: Integers, placement: Placement, glass: Mask | None = None) -> Camera:
    """A perspective view in world space of the unit-space triangles.

    Where surfaces face many points from most sides, the scene is a room: the camera looks at the one with most room
    around from where the view of it is deepest, at the height of a person's eyes if the scene is as high as that and
    no mountain. Otherwise it is an
    object, seen whole from above one corner. glass (triangle,): what one sees through, which encloses nothing.
    """
    points, normals, faces = _surface_points(vertices.astype(np.float64), triangles)
    low, high = points.min(axis=0), points.max(axis=0)
    if glass is not None:
        points, normals = points[~glass[faces]], normals[~glass[faces]]
    around = _Surroundings(points, normals)
    stands = [around.seen_from(low + (high - low) * at) for at in product(_ALONG, _UP, _ALONG)]
    rooms = [stand for stand in stands if stand.enclosed >= _ENCLOSED and stand.covered >= _COVERED]
    metre = placement.scale
    height = high[1] - low[1]
    if len(rooms) >= len(stands) * (_ROOM if height >= HEADROOM * metre else _SMALL_ROOM):
        if HEADROOM * metre <= height <= _TALLEST * metre:
            columns = sorted({(float(stand.eye[0]), float(stand.eye[2])) for stand in rooms})
            eyes = standing_eyes(columns, vertices.astype(np.float64), triangles, metre)
            standing = [around.seen_from(eye) for eye in eyes]
            rooms = [stand for stand in standing if stand.covered >= _INDOORS] or rooms
        middle = max(rooms, key=lambda stand: stand.openness)
        best = max(rooms, key=lambda stand: stand.view_of(middle))
        seen = np.isfinite(best.view_of(middle))
        eye, target = (best.eye, middle.eye * (1, 0, 1) + best.eye * (0, 1, 0)) if seen else _ahead(middle)
    else:
        target = (low + high) / 2.0
        radius = float(np.linalg.norm(high - low)) / 2.0
        eye = target + np.array([0.5, 0.35, 0.8]) / np.linalg.norm([0.5, 0.35, 0.8]) * radius / np.sin(np.radians(30.0))
    world = [(point / placement.scale + placement.centre).tolist() for point in (eye, target)]
    return look_at(world[0], world[1], name="default")


def _surface_points(vertices: Doubles, triangles: Integers) -> tuple[Doubles, Doubles, Integers]:
    """Points spread evenly over all triangles, (sample, 3), the geometric normals there, and these triangles."""
    faces = area_vectors(vertices, triangles)
    areas = lengths(faces)
    random = np.random.default_rng(0)
    chosen = np.searchsorted(np.cumsum(areas / areas.sum()), random.random(_SAMPLES)).clip(0, len(triangles) - 1)
    root, other = np.sqrt(random.random((_SAMPLES, 1))), random.random((_SAMPLES, 1))
    a, b, c = (vertices[triangles[chosen, corner]] for corner in range(3))
    return (1.0 - root) * a + root * (1.0 - other) * b + root * other * c, faces[chosen], chosen


class _Surroundings:
    """Points (sample, 3) on surfaces with these normals, and what is seen of them from others."""

    def __init__(self, points: Doubles, normals: Doubles) -> None:
        self._points, self._normals = np.ascontiguousarray(points.T), np.ascontiguousarray(normals.T)
        self._cells: dict[tuple[float, float], Integers] = {}  # of azimuth, the same for all eyes above one another

    def seen_from(self, eye: Doubles) -> _Standpoint:
        """What `eye` sees of the points: the nearest in each cell of directions."""
        offsets = self._points - eye[:, None]
        x, y, z = offsets
        distance = np.maximum(np.sqrt(x * x + y * y + z * z), 1e-9)
        column = float(eye[0]), float(eye[2])
        if column not in self._cells:
            self._cells[column] = _azimuth(offsets.T) * _HEIGHTS
        height = np.minimum(((y / distance + 1.0) / 2.0 * _HEIGHTS).astype(np.int64), _HEIGHTS - 1)
        cell = self._cells[column] + height
        nearest = np.full(_AZIMUTHS * _HEIGHTS, np.inf)
        np.minimum.at(nearest, cell, distance)
        seen = np.flatnonzero(distance == nearest[cell])
        fronts = np.einsum("cs,cs->s", offsets[:, seen], self._normals[:, seen]) < 0.0
        above = fronts & (height[seen] >= _HEIGHTS // 2)
        depth = np.where(np.isfinite(nearest), nearest, 0.0).reshape(_AZIMUTHS, _HEIGHTS)
        # The mean of logarithms: one thing close in front of the camera, or the void, spoils a view.
        open_ = np.log(np.maximum(depth[:, _HEIGHTS // 4 : -_HEIGHTS // 4], _NEAR)).mean(axis=1)
        return _Standpoint(
            enclosed=float(fronts.sum()) / nearest.size,
            covered=float(above.sum()) / (nearest.size / 2),
            openness=float(open_.mean()),
            views=open_[_BESIDE].sum(axis=0) / len(_BESIDE),
            reach=depth[:, _HEIGHTS // 2 - 1 : _HEIGHTS // 2 + 1].min(axis=1),
            eye=eye,
        )


def _azimuth(offsets: Doubles) -> Integers:
    """The cell of azimuth of directions (…, 3)."""
    turns = np.arctan2(offsets[..., 2], offsets[..., 0]) / (2.0 * np.pi)
    return np.floor(turns * _AZIMUTHS).astype(np.int64) % _AZIMUTHS


def _ahead(stand: _Standpoint) -> tuple[Doubles, Doubles]:
    """The point and what to look at from there: where it is most open."""
    angle = (int(np.argmax(stand.views)) + 0.5) / _AZIMUTHS * 2.0 * np.pi
    return stand.eye, stand.eye + np.array([np.cos(angle), 0.0, np.sin(angle)])

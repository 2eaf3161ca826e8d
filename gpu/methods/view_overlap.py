"""How much of what a camera sees another sees, too."""

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np

from gpu.scene.types import Camera, Doubles

# Places across an image, from edge to edge, where views are compared; those in its middle are within MIDDLE of its
# centre, and MIDDLE_SHARE of all.
_ACROSS = np.linspace(-0.95, 0.95, 20)
MIDDLE = 0.76
MIDDLE_SHARE = float(np.mean(np.abs(_ACROSS) < MIDDLE)) ** 2


@dataclass(frozen=True)
class ViewOverlapParameters:
    """When a frame of a walk builds on the last one.

    usual_distance: what a walk sees is about so far away, in unit space; min_overlap: where less of it than this share
    was seen before, nothing is built on; like_side: cosine between the ways to what both see from a like side;
    short_way: of that distance, so short a way of the camera's leaves all that it sees at a like side.
    """

    usual_distance: float = 0.3
    min_overlap: float = 0.5
    like_side: float = 0.5
    short_way: float = 0.5


VIEW_OVERLAP_PARAMETERS = ViewOverlapParameters()


@lru_cache(maxsize=8)
def _compared(aspect: float, half_height: float, distance: float, orthographic: bool) -> tuple[Doubles, Doubles]:
    """Points that a camera sees at a `distance`, in its own space, and ways to them; (3, point) each."""
    x, y = np.meshgrid(_ACROSS * aspect, _ACROSS)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    points *= half_height * (1.0 if orthographic else distance)
    points[2] = -distance
    ways = np.array([[0.0], [0.0], [-1.0]]) if orthographic else points / np.linalg.norm(points, axis=0)
    return points, ways


def view_overlap(camera: Camera, last: Camera, aspect: float, distance: float) -> float:
    """The share, 0 to 1, of what `camera` sees at a `distance` [world units] that `last` sees too, from a like side.

    aspect: width over height of both images, whatever the cameras' own are.
    """
    points, here = _compared(aspect, camera.half_height, distance, camera.orthographic)
    axes, others = (of / np.sqrt((of * of).sum(axis=0)) for of in (camera.to_world[:3, :3], last.to_world[:3, :3]))
    turn = others.T @ axes
    seen = turn @ points + others.T @ (camera.to_world[:3, 3:] - last.to_world[:3, 3:])
    x, y, z = seen
    half = last.half_height * (1.0 if last.orthographic else -z)
    inside = (z < 0.0) & (np.abs(x) <= half * aspect) & (np.abs(y) <= half)
    like_side = VIEW_OVERLAP_PARAMETERS.like_side
    if last.orthographic:
        alike = -(turn @ here)[2] > like_side
    else:
        alike = (turn @ here * seen).sum(axis=0) > like_side * np.sqrt((seen * seen).sum(axis=0))
    return float(np.count_nonzero(inside & alike)) / points.shape[1]


def is_seen_again(camera: Camera, last: Camera, aspect: float, distance: float) -> bool:
    """Whether `view_overlap` is min_overlap or more. Of two cameras near each other four points tell that."""
    return _shares_middle(camera, last, aspect, distance) or (
        view_overlap(camera, last, aspect, distance) >= VIEW_OVERLAP_PARAMETERS.min_overlap
    )


def _shares_middle(camera: Camera, last: Camera, aspect: float, distance: float) -> bool:
    """Whether the middle of what `camera` sees is surely seen by `last` from a like side, and is enough.

    If the corners of a rectangle are in a picture, so is all of it. NumPy would take ten times as long for four points.
    """
    if camera.orthographic or last.orthographic or VIEW_OVERLAP_PARAMETERS.min_overlap > MIDDLE_SHARE:
        return False
    axes, eye = _axes(camera)
    others, other_eye = _axes(last)
    way = [here - there for here, there in zip(eye, other_eye, strict=True)]
    if sum(part * part for part in way) > (VIEW_OVERLAP_PARAMETERS.short_way * distance) ** 2:
        return False
    shift = [sum(a * b for a, b in zip(other, way, strict=True)) for other in others]
    turn = [[sum(a * b for a, b in zip(other, axis, strict=True)) for axis in axes] for other in others]
    up = MIDDLE * camera.half_height * distance
    for x in (-up * aspect, up * aspect):
        for y in (-up, up):
            right, above, back = (
                row[0] * x + row[1] * y - row[2] * distance + along for row, along in zip(turn, shift, strict=True)
            )
            half = -last.half_height * back
            if back >= 0.0 or abs(right) > half * aspect or abs(above) > half:
                return False
    return True


def _axes(camera: Camera) -> tuple[list[list[float]], list[float]]:
    """A camera's axes in world space, of unit length, and where it is."""
    rows = camera.to_world.tolist()[:3]
    columns = [[row[place] for row in rows] for place in range(4)]
    lengths = [sqrt(x * x + y * y + z * z) for x, y, z in columns[:3]]
    axes = [[part / length for part in axis] for axis, length in zip(columns[:3], lengths, strict=True)]
    return axes, columns[3]

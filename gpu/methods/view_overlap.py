"""How much of what a camera sees another sees, too."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gpu.scene.types import Camera, Doubles

# Places across an image, from edge to edge, where views are compared.
_ACROSS = np.linspace(-0.95, 0.95, 20)


@dataclass(frozen=True)
class ViewOverlapParameters:
    """When a frame of a walk builds on the last one.

    usual_distance: what a walk sees is about so far away, in unit space; min_overlap: where less of it than this share
    was seen before, nothing is built on; like_side: cosine between the ways to what both see from a like side.
    """

    usual_distance: float = 0.3
    min_overlap: float = 0.5
    like_side: float = 0.5


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


def view_overlap(camera: Camera, last: Camera, aspect: float, distance: float,
                 chosen: ViewOverlapParameters = VIEW_OVERLAP_PARAMETERS) -> float:  # fmt: skip
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
    if last.orthographic:
        alike = -(turn @ here)[2] > chosen.like_side
    else:
        alike = (turn @ here * seen).sum(axis=0) > chosen.like_side * np.sqrt((seen * seen).sum(axis=0))
    return float(np.count_nonzero(inside & alike)) / points.shape[1]

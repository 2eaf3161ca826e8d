"""Cameras from where the eye is and what it looks at."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from math import cos, isfinite, radians, sin, tan

import numpy as np

from gpu.errors import UserError
from gpu.scene.types import Camera, Doubles

# Places across an image, from edge to edge, where views are compared.
_ACROSS = np.linspace(-0.95, 0.95, 20)
_LIKE_SIDE = 0.5  # cosine between the ways to what both see


class CameraError(UserError):
    """A camera cannot be made from these numbers."""


def look_at(
    eye: Sequence[float],
    target: Sequence[float],
    up: Sequence[float] = (0.0, 1.0, 0.0),
    yfov_degrees: float = 60.0,
    aspect: float = 16.0 / 9.0,
    name: str = "",
) -> Camera:
    """A perspective camera at `eye` that looks towards `target`, both (3,) in world space.

    yfov_degrees: the whole vertical angle of view, above 0 and below 180; aspect: width over height. Where the view is
    parallel to `up`, the picture's top points away from +Z (so that a plan has north on top).
    Raises CameraError for non-finite numbers, for eye = target, and for an angle or aspect out of range.
    """
    position, aim, upward = (np.asarray(vector, dtype=np.float64) for vector in (eye, target, up))
    for label, vector in (("eye", position), ("target", aim), ("up", upward)):
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise CameraError(f"camera: {label}: needs three finite numbers, got {vector.tolist()}")
    if not 0.0 < yfov_degrees < 180.0:
        raise CameraError(f"camera: field of view: needs an angle between 0 and 180 degrees, got {yfov_degrees}")
    if not (isfinite(aspect) and aspect > 0.0):
        raise CameraError(f"camera: aspect: needs a positive number, got {aspect}")
    distance, up_length = np.linalg.norm(aim - position), np.linalg.norm(upward)
    if not distance > 0.0:
        raise CameraError("camera: target: is where the eye is; move one of them")
    if not up_length > 0.0:
        raise CameraError("camera: up: has no length; use for example 0 1 0")
    backward = (position - aim) / distance
    right = np.cross(upward / up_length, backward)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross((0.0, 0.0, -1.0) if abs(backward[2]) < 0.9 else (0.0, 1.0, 0.0), backward)
    right /= np.linalg.norm(right)
    to_world = np.eye(4)
    to_world[:3, :4] = np.stack([right, np.cross(backward, right), backward, position], axis=1)
    return Camera(name=name, to_world=to_world, half_height=tan(radians(yfov_degrees) / 2.0), aspect=float(aspect))


def turned(camera: Camera, degrees: float) -> Camera:
    """`camera` turned about its own vertical axis, to its left."""
    angle = radians(degrees)
    turn = np.eye(4)
    turn[0, 0] = turn[2, 2] = cos(angle)
    turn[0, 2], turn[2, 0] = sin(angle), -sin(angle)
    return replace(camera, to_world=camera.to_world @ turn)


@lru_cache(maxsize=8)
def _compared(aspect: float, half_height: float, distance: float, orthographic: bool) -> tuple[Doubles, Doubles]:
    """Points that a camera sees at a `distance`, in its own space, and ways to them; (3, point) each."""
    x, y = np.meshgrid(_ACROSS * aspect, _ACROSS)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    points *= half_height * (1.0 if orthographic else distance)
    points[2] = -distance
    ways = np.array([[0.0], [0.0], [-1.0]]) if orthographic else points / np.linalg.norm(points, axis=0)
    return points, ways


def seen_again(camera: Camera, last: Camera, aspect: float, distance: float) -> float:
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
        alike = -(turn @ here)[2] > _LIKE_SIDE
    else:
        alike = (turn @ here * seen).sum(axis=0) > _LIKE_SIDE * np.sqrt((seen * seen).sum(axis=0))
    return float(np.count_nonzero(inside & alike)) / points.shape[1]

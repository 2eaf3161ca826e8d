"""Cameras from where the eye is and what it looks at."""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, isfinite, radians, sin, tan

import numpy as np

from gpu.errors import UserError
from gpu.scene.types import Camera

FARTHEST = 1e150
"""Of a camera from the origin [m]: the squares of distances must be numbers."""


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
    Raises CameraError for numbers that are not finite or beyond FARTHEST, for eye = target, and for an angle or aspect
    out of range.
    """
    position, aim, upward = (np.asarray(vector, dtype=np.float64) for vector in (eye, target, up))
    for label, vector in (("eye", position), ("target", aim), ("up", upward)):
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise CameraError(f"camera: {label}: needs three finite numbers, got {vector.tolist()}")
        if np.abs(vector).max() > FARTHEST:
            raise CameraError(f"camera: {label}: needs numbers of up to {FARTHEST:g}, got {vector.tolist()}")
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


def rotated(camera: Camera, degrees: float) -> Camera:
    """`camera` turned about its own vertical axis, to its left."""
    angle = radians(degrees)
    turn = np.eye(4)
    turn[0, 0] = turn[2, 2] = cos(angle)
    turn[0, 2], turn[2, 0] = sin(angle), -sin(angle)
    return replace(camera, to_world=camera.to_world @ turn)

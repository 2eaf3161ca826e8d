"""A camera's way through keyframes: a spline of places, of pan, tilt and roll, and of the field of view.

Everything is a cubic of time between two keyframes, smooth (C1) at each. Places have the directions of a centripetal
Catmull-Rom curve (Yuksel, Schaefer and Keyser, Parameterization and Applications of Catmull-Rom Curves, 2011), which
makes no loops between two keyframes; how fast they are passed, and all that is a number, has the slopes of a monotone
cubic (Fritsch and Butland 1984), so that nothing leaves the range between two keyframes, and what is alike stays.

Orientations are pan, tilt and roll rather than quaternions: between two level views the horizon stays level and the
tilt between theirs, as on a tripod, where the shortest rotation would bank and dip. The page's preview
(web/viewer/camera-path.js) is the same spline.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, cos, exp, hypot, log, pi, sin

import numpy as np

from gpu.scene.camera import CameraError
from gpu.scene.types import Camera, Doubles

STRAIGHT = 1e-6  # of a gaze: the share across the vertical below which it has no heading of its own


@dataclass(frozen=True)
class _Turns:
    """Of a gaze [rad]: its heading, counter-clockwise about +Y from −Z; above the horizon; about itself."""

    pan: float
    tilt: float
    roll: float


class CameraPath:
    """A camera that passes each of `cameras` at its time.

    times: (K,) strictly increasing [s], K ≥ 2. Raises CameraError where some cameras are orthographic and others not.
    """

    def __init__(self, times: Sequence[float], cameras: Sequence[Camera]) -> None:
        for index, camera in enumerate(cameras):
            if camera.orthographic != cameras[0].orthographic:
                kinds = ("is in perspective", "is orthographic")
                is_first, is_this = (kinds[it.orthographic] for it in (cameras[0], camera))
                raise CameraError(f"keyframes[{index}].camera: {is_this}, but the first one {is_first}; use one kind")
        self._first, self._times = cameras[0], np.array(times, dtype=np.float64)
        places = np.array([camera.to_world[:3, 3] for camera in cameras], dtype=np.float64)
        turns = [_turns(camera.to_world) for camera in cameras]
        numbers = [
            _unwrapped([turn.pan for turn in turns]),
            [turn.tilt for turn in turns],
            _unwrapped([turn.roll for turn in turns]),
            [log(camera.half_height) for camera in cameras],
            [camera.near for camera in cameras],
        ]
        slopes = [monotone_slopes(self._times, np.array(values)) for values in numbers]
        self._values = np.column_stack([places, *numbers])
        self._slopes = np.column_stack([velocities(self._times, places), *slopes])

    def at(self, time: float) -> Camera:
        """The camera at a time [s]; before the first keyframe and after the last, those."""
        values = _hermite(self._times, self._values, self._slopes, time)
        pan, tilt, roll, zoom, near = values[3:].tolist()
        to_world = np.eye(4)
        to_world[:3, :3] = _rotation(_Turns(pan, tilt, roll))
        to_world[:3, 3] = values[:3]
        return replace(self._first, name="", to_world=to_world, half_height=exp(zoom), near=near)


def monotone_slopes(times: Doubles, values: Doubles) -> Doubles:
    """Derivatives (K,) of values (K,) by time, with which cubics between are monotone; at the ends, of a straight line.

    Between: the weighted harmonic mean of the secants on both sides, 0 at an extremum (Fritsch and Butland 1984).
    """
    lengths = np.diff(times)
    secants = np.diff(values) / lengths
    before, after = secants[:-1], secants[1:]
    weights = 2.0 * lengths[1:] + lengths[:-1], lengths[1:] + 2.0 * lengths[:-1]
    turns = before * after <= 0.0
    mean = (weights[0] + weights[1]) / (
        weights[0] / np.where(turns, 1.0, before) + weights[1] / np.where(turns, 1.0, after)
    )
    return np.concatenate([secants[:1], np.where(turns, 0.0, mean), secants[-1:]])


def velocities(times: Doubles, points: Doubles) -> Doubles:
    """Derivatives (K, 3) of points (K, 3) by time: along a centripetal Catmull-Rom curve; at the ends, straight.

    Where two neighbours are one point, the camera rests.
    """
    steps = np.diff(points, axis=0)
    lengths = np.sqrt(np.linalg.norm(steps, axis=1))  # of the curve's parameter
    rates = monotone_slopes(times, np.concatenate([[0.0], np.cumsum(lengths)]))[1:-1]
    rests = rates == 0.0
    before, after = (np.where(rests, 1.0, length)[:, None] for length in (lengths[:-1], lengths[1:]))
    tangents = (after / before * steps[:-1] + before / after * steps[1:]) / (before + after)
    ends = steps[[0, -1]] / np.diff(times)[[0, -1], None]
    return np.concatenate([ends[:1], rates[:, None] * tangents, ends[1:]])


def _hermite(knots: Doubles, values: Doubles, slopes: Doubles, at: float) -> Doubles:
    """The cubic (N,) of the two knots around `at`, with their values and derivatives (K, N)."""
    left = int(np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2))
    length = knots[left + 1] - knots[left]
    share = float(np.clip((at - knots[left]) / length, 0.0, 1.0))
    rest = 1.0 - share
    ends: Doubles = values[left] * rest**2 * (1.0 + 2.0 * share) + values[left + 1] * share**2 * (1.0 + 2.0 * rest)
    return ends + length * share * rest * (slopes[left] * rest - slopes[left + 1] * share)


def _unwrapped(angles: Sequence[float]) -> list[float]:
    """Angles [rad] as a way of less than half a turn from each to the next."""
    way = [angles[0]]
    for angle in angles[1:]:
        step = angle - way[-1]
        way.append(way[-1] + step - 2.0 * pi * ceil(step / (2.0 * pi) - 0.5))
    return way


def _turns(to_world: Doubles) -> _Turns:
    """Pan, tilt and roll of a camera; one that looks straight up or down pans where its picture's top points."""
    right, up, back = to_world[:3, 0], to_world[:3, 1], to_world[:3, 2]
    level = hypot(back[0], back[2])
    tilt = float(np.arctan2(-back[1], level))
    if level <= STRAIGHT * abs(back[1]):
        return _Turns(float(np.arctan2(*(-np.sign(back[1]) * up[[0, 2]]))), tilt, 0.0)
    pan = float(np.arctan2(back[0], back[2]))
    levelled = _rotation(_Turns(pan, tilt, 0.0))
    return _Turns(pan, tilt, float(np.arctan2(right @ levelled[:, 1], right @ levelled[:, 0])))


def _rotation(turns: _Turns) -> Doubles:
    """The axes (3, 3) of a camera, right, up and back, as columns."""
    (sp, cp), (st, ct), (sr, cr) = ((sin(angle), cos(angle)) for angle in (turns.pan, turns.tilt, turns.roll))
    level = np.array([[cp, sp * st, sp * ct], [0.0, ct, -st], [-sp, cp * st, cp * ct]])
    return level @ np.array([[cr, -sr, 0.0], [sr, cr, 0.0], [0.0, 0.0, 1.0]])

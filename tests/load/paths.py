"""Camera paths: made from a scene's box and a seed, or recorded in JSON lines. Poses are camera to world, rigid."""

import json
import math
import random
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

from gpu.errors import UserError
from server.wire.browser import Bounds, check_rigid

YFOV = 1.0  # [rad]
ORBIT_SECONDS, WALK_SECONDS = 20.0, 40.0
# How much of the box paths keep to, as a share of its half: the outermost of it is walls.
ORBIT_SHARE, WALK_SHARE = 0.6, 0.5
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class View:
    """A camera: 16 numbers, column after column, and its vertical field of view [rad]."""

    matrix: tuple[float, ...]
    yfov: float


class CameraPath(Protocol):
    """Where a camera is at any time; the same seed gives the same path."""

    def at(self, seconds: float) -> View:
        """The view so long after the start."""


PathMaker = Callable[[Bounds, int], CameraPath]


class Orbit:
    """Round the middle of the box, which the camera looks at."""

    def __init__(self, bounds: Bounds, seed: int) -> None:
        """The seed says where it starts, which way it goes and how high."""
        chance = random.Random(seed)
        self._centre, self._half = _box(bounds)
        self._start = chance.uniform(0.0, 2.0 * math.pi)
        self._speed = chance.choice([-1.0, 1.0]) * 2.0 * math.pi / ORBIT_SECONDS
        self._height = chance.uniform(-0.5, 0.5)

    def at(self, seconds: float) -> View:
        """One round takes ORBIT_SECONDS."""
        angle = self._start + self._speed * seconds
        around = (math.cos(angle), self._height, math.sin(angle))
        away = _times(ORBIT_SHARE, around, self._half)
        return View(looking(_plus(self._centre, away), _times(-1.0, away)), YFOV)


class Walk:
    """To and fro through the box, looking about."""

    def __init__(self, bounds: Bounds, seed: int) -> None:
        """The seed says where each movement starts."""
        chance = random.Random(seed)
        self._centre, self._half = _box(bounds)
        self._phases = [chance.uniform(0.0, 2.0 * math.pi) for _ in range(5)]

    def at(self, seconds: float) -> View:
        """Sines of periods that do not fit each other, about WALK_SECONDS."""
        x, y, z, yaw, pitch = self._phases
        turns = 2.0 * math.pi * seconds / WALK_SECONDS
        place = (math.sin(x + turns), 0.3 * math.sin(y + 0.31 * turns), math.sin(z + 1.37 * turns))
        yaw += 2.0 * turns + 0.6 * math.sin(5.0 * turns)
        pitch = 0.25 * math.sin(pitch + 3.0 * turns)
        ahead = (math.cos(yaw) * math.cos(pitch), math.sin(pitch), math.sin(yaw) * math.cos(pitch))
        return View(looking(_plus(self._centre, _times(WALK_SHARE, place, self._half)), ahead), YFOV)


@dataclass(frozen=True)
class Resting:
    """Another path that stands still for `rest` seconds after every `move` seconds, as people do."""

    path: CameraPath
    move: float = 6.0
    rest: float = 3.0

    def at(self, seconds: float) -> View:
        """The other path's view, whose time stands still in rests."""
        rounds, into = divmod(seconds, self.move + self.rest)
        return self.path.at(rounds * self.move + min(into, self.move))


@dataclass(frozen=True)
class Recorded:
    """Views at times [s] from 0, increasing; it starts again when it is over."""

    times: tuple[float, ...]
    views: tuple[View, ...]

    def at(self, seconds: float) -> View:
        """The last view that had been recorded then."""
        into = seconds % self.times[-1] if self.times[-1] > 0.0 else 0.0
        return self.views[bisect_right(self.times, into) - 1]


MADE: dict[str, PathMaker] = {
    "orbit": Orbit,
    "walk": Walk,
    "rests": lambda bounds, seed: Resting(Walk(bounds, seed)),
}


def path_maker(name: str) -> PathMaker:
    """The kind of path of this name, or the recorded one in a file; UserError when there is neither."""
    if name in MADE:
        return MADE[name]
    if not Path(name).is_file():
        raise UserError(f"{name}: there is no such recorded path; those that are made are {', '.join(MADE)}")
    recorded = read_path(Path(name))
    return lambda bounds, seed: recorded


def looking(eye: Vector, ahead: Vector) -> tuple[float, ...]:
    """Camera to world, column-major, from `eye` along `ahead`, which must not be straight up or down."""
    z = _times(-1.0 / math.hypot(*ahead), ahead)
    flat = math.hypot(z[0], z[2])
    x = (z[2] / flat, 0.0, -z[0] / flat)  # up × z
    y = (z[1] * x[2], z[2] * x[0] - z[0] * x[2], -z[1] * x[0])  # z × x
    return (*x, 0.0, *y, 0.0, *z, 0.0, *eye, 1.0)


def write_path(file: Path, times: Sequence[float], views: Sequence[View]) -> None:
    """One line per view: {"seconds", "matrix", "yfov"}."""
    lines = [json.dumps({"seconds": time, **asdict(view)}) for time, view in zip(times, views, strict=True)]
    file.write_text("".join(line + "\n" for line in lines))


def read_path(file: Path) -> Recorded:
    """A recorded path, moved to start at 0; UserError with the line that is wrong."""
    times: list[float] = []
    views: list[View] = []
    for number, line in enumerate(file.read_text().splitlines(), 1):
        try:
            entry = json.loads(line)
            seconds, matrix, yfov = float(entry["seconds"]), tuple(map(float, entry["matrix"])), float(entry["yfov"])
            if len(matrix) != 16 or not all(map(math.isfinite, (seconds, yfov, *matrix))):
                raise ValueError("must be finite numbers, 16 of them in matrix")
            check_rigid(matrix)
            if times and seconds < times[-1]:
                raise ValueError("seconds must not decrease")
        except KeyError as error:
            raise UserError(f"{file}, line {number}: there is no {error}") from None
        except (ValueError, TypeError) as error:
            raise UserError(f"{file}, line {number}: {error}") from None
        times.append(seconds)
        views.append(View(matrix, yfov))
    if not views:
        raise UserError(f"{file}: no poses were recorded")
    return Recorded(tuple(time - times[0] for time in times), tuple(views))


def _box(bounds: Bounds) -> tuple[Vector, Vector]:
    """Its middle and half its sides."""
    sides = list(zip(bounds.min, bounds.max, strict=True))
    x, y, z = ((low + high) / 2.0 for low, high in sides)
    half_x, half_y, half_z = (max((high - low) / 2.0, 1e-6) for low, high in sides)
    return (x, y, z), (half_x, half_y, half_z)


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _times(factor: float, a: Vector, b: Vector = (1.0, 1.0, 1.0)) -> Vector:
    return factor * a[0] * b[0], factor * a[1] * b[1], factor * a[2] * b[2]

"""Camera paths: made from a scene's box and a seed, or recorded in JSON lines. Poses are camera to world, rigid."""

import json
import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gpu.errors import UserError
from server.protocol import Bounds, check_rigid

YFOV = 1.0  # [rad]
ORBIT_SECONDS, WALK_SECONDS = 20.0, 40.0
# How much of the box paths keep to, as a share of its half: the outermost of it is walls.
ORBIT_SHARE, WALK_SHARE = 0.6, 0.5
UP = np.array([0.0, 1.0, 0.0])
Vector = NDArray[np.float64]


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


@dataclass(frozen=True)
class Orbit:
    """Round the middle of the box, which the camera looks at."""

    bounds: Bounds
    seed: int

    def at(self, seconds: float) -> View:
        """One round takes ORBIT_SECONDS; the seed says where it starts, which way it goes and how high."""
        start, side, height = np.random.default_rng(self.seed).uniform(-1.0, 1.0, 3)
        angle = math.pi * start + math.copysign(2.0 * math.pi, side) * seconds / ORBIT_SECONDS
        centre, half = _box(self.bounds)
        share = ORBIT_SHARE * np.array([math.cos(angle), 0.5 * height, math.sin(angle)])
        return View(looking(centre + share * half, -share * half), YFOV)


@dataclass(frozen=True)
class Walk:
    """To and fro through the box, looking about."""

    bounds: Bounds
    seed: int

    def at(self, seconds: float) -> View:
        """Sines of periods that do not fit each other, about WALK_SECONDS, with the seed's phases."""
        phases = np.random.default_rng(self.seed).uniform(0.0, 2.0 * math.pi, 5)
        turns = 2.0 * math.pi * seconds / WALK_SECONDS
        centre, half = _box(self.bounds)
        place = np.sin(phases[:3] + turns * np.array([1.0, 0.31, 1.37])) * np.array([1.0, 0.3, 1.0])
        yaw = phases[3] + 2.0 * turns + 0.6 * math.sin(5.0 * turns)
        pitch = 0.25 * math.sin(phases[4] + 3.0 * turns)
        ahead = np.array([math.cos(yaw) * math.cos(pitch), math.sin(pitch), math.sin(yaw) * math.cos(pitch)])
        return View(looking(centre + WALK_SHARE * place * half, ahead), YFOV)


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
    z = -ahead / np.linalg.norm(ahead)
    x = np.cross(UP, z)
    x /= np.linalg.norm(x)
    axes = np.zeros((4, 4))
    axes[0, :3], axes[1, :3], axes[2, :3], axes[3] = x, np.cross(z, x), z, [*eye, 1.0]
    return tuple(float(value) for value in axes.ravel())


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
    low, high = np.array(bounds.min), np.array(bounds.max)
    return (low + high) / 2.0, np.maximum((high - low) / 2.0, 1e-6)

"""Which axis of a file is up and how long its unit is: as the user says, else the file, else by what is in it.

Each guess is a sentence for the report, and an import option overrules it.
"""

from dataclasses import dataclass

import numpy as np

from gpu.scene.file_frame import FileFrame
from gpu.scene.geometry.boxes import lengths, middles
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.import_options import METRES, Axis, ImportOptions
from gpu.scene.types import Doubles, Integers

# Higher than this in metres [m], a scene is not in metres: few buildings reach 200 m, and none reaches 2 km; but what
# is higher than a kilometre in millimetres is not in these either.
CENTIMETRES, MILLIMETRES, HIGHEST = 200.0, 2e3, 1e6
# Height over width: below is a landscape, above a tower, which are as large as they seem.
LANDSCAPE, TOWER = 0.1, 2.0
# A triangle faces along an axis when its normal is within some 25° of it.
FACING = 0.9
# So sure is the guess of a room: floor and ceiling against walls, and height against width and depth.
LARGER, LOWER = 1.1, 0.9
# On a map, east and north are this many units and extents from zero, and heights are this small beside them.
MAP_UNITS, MAP_EXTENTS, MAP_HEIGHT = 1e4, 10.0, 0.02


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles (triangle, 3) of positions (vertex, 3) in a file's coordinates, and the box around them (3,)."""

    positions: Doubles
    triangles: Integers
    low: Doubles
    high: Doubles


def frame_of(
    shape: Shape, up: Axis | None, metres_per_unit: float | None, options: ImportOptions
) -> tuple[FileFrame, list[str]]:
    """The coordinates of a file that says `up` and `metres_per_unit` (None: nothing), and sentences on the guesses.

    The origin is the one that `options` give (the scene's middle is rounded to whole units), else the file's own.
    """
    metres, chosen = said_metres(metres_per_unit, options), options.up or up
    notes: list[str] = []
    if chosen is None:
        chosen, notes = guessed_up(shape)
    if options.unit is None and metres_per_unit is None:
        extents = shape.high - shape.low
        x, height, z = np.abs(FileFrame(chosen).turned(extents))
        metres, more = guessed_unit(float(height), float(max(x, z)))
        notes += more
    origin = options.origin or (0.0, 0.0, 0.0)
    if origin == "auto":
        x, y, z = np.round(shape.low + (shape.high - shape.low) / 2.0).tolist()
        origin = (x, y, z)
    return FileFrame(chosen, metres, origin), notes


def said_metres(metres_per_unit: float | None, options: ImportOptions) -> float:
    """The length of the file's unit [m] as the user or the file say; 1 where neither does."""
    return METRES[options.unit] if options.unit else metres_per_unit or 1.0


def guessed_up(shape: Shape) -> tuple[Axis, list[str]]:
    """The axis that points up, +Y unless there is reason to take +Z, and a sentence that says so then."""
    middle, extents = (shape.low + shape.high) / 2.0, shape.high - shape.low
    east_north = float(np.abs(middle[:2]).min())
    if east_north > max(MAP_UNITS, MAP_EXTENTS * extents.max()) and abs(middle[2]) < MAP_HEIGHT * east_north:
        return "z", ["+Z was taken as up, since x and y are coordinates of a map; if it is not, choose up y"]
    if extents[2] < LOWER * extents[:2].min():
        x, y, z = _facing_areas(shape)
        if z > LARGER * max(x, y):
            return "z", ["+Z was taken as up, since floor and ceiling lie across it; if it is not, choose up y"]
    return "y", []


def guessed_unit(height: float, width: float) -> tuple[float, list[str]]:
    """The length [m] of the unit of a scene so high and wide, and a sentence unless it is a metre."""
    if CENTIMETRES < height <= HIGHEST and LANDSCAPE * width <= height <= TOWER * width:
        name, unit = ("millimetre", 0.001) if height > MILLIMETRES else ("centimetre", 0.01)
        return unit, [
            f"its unit was taken to be a {name}, since it is {height:,.0f} units high; if it is not, choose the unit"
        ]
    return 1.0, []


def _facing_areas(shape: Shape) -> list[float]:
    """For each axis the smaller area of floor and ceiling along it; 0 unless they face each other, as a room's do."""
    positions = (shape.positions - shape.low) / (shape.high - shape.low).max()
    vectors = area_vectors(positions, shape.triangles)
    areas, levels = lengths(vectors), middles(positions, shape.triangles)
    return [_facing_area(vectors[:, axis], areas, levels[:, axis]) for axis in range(3)]


def _facing_area(along: Doubles, areas: Doubles, levels: Doubles) -> float:
    """The smaller area of floor and ceiling of triangles (triangle,), whose area vectors are so long along an axis."""
    floor, ceiling = (sign * along > FACING * areas for sign in (1.0, -1.0))
    least = float(min(areas[floor].sum(), areas[ceiling].sum()))
    if least == 0.0 or np.average(levels[floor], weights=areas[floor]) >= np.average(
        levels[ceiling], weights=areas[ceiling]
    ):
        return 0.0
    return least

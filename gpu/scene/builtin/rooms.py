"""What rooms are made of: walls with openings, windows with blinds, doors, skirting boards, framed pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from gpu.scene.builtin.shape import Shape, copies, join, rotation
from gpu.scene.builtin.shapes import box, cylinder, moulding, quad, rectangle, rounded_path, surface, tube
from gpu.scene.types import Doubles

LAP = 0.01  # metres that floors, walls and ceilings run past each other, so that no light comes through the corners


@dataclass(frozen=True)
class Opening:
    """A rectangular hole in a wall: from (left, bottom) to (right, top), metres from the wall's lower left corner."""

    left: float
    bottom: float
    right: float
    top: float

    @property
    def width(self) -> float:
        """Metres across."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Metres from bottom to top."""
        return self.top - self.bottom


def level(x: float, z: float, y: float) -> Shape:
    """A floor of half sides `x` and `z` at the height `y`, facing up, with LAP more on every side."""
    x, z = x + LAP, z + LAP
    return quad((-x, y, z), (2 * x, 0, 0), (0, 0, -2 * z)).mapped_uv(-LAP, -LAP)


def wall(width: float, height: float, openings: Sequence[Opening] = (), depth: float = 0.2) -> Shape:
    """A wall in the plane z = 0 from (0, 0) to (width, height) that faces +Z, its openings lined `depth` towards −Z.

    It runs LAP further on at its sides, past the walls that it meets there.
    Openings must not share a column or row of the wall unless they share both edges there, so that no edge of one face
    ends in the middle of another's.
    """
    xs = sorted({-LAP, width + LAP, *(x for hole in openings for x in (hole.left, hole.right))})
    ys = sorted({0.0, height, *(y for hole in openings for y in (hole.bottom, hole.top))})
    cells = [
        quad((x, y, 0), (right - x, 0, 0), (0, top - y, 0)).mapped_uv(x, y)
        for x, right in pairwise(xs)
        for y, top in pairwise(ys)
        if not any(hole.left <= x < hole.right and hole.bottom <= y < hole.top for hole in openings)
    ]
    return join([*cells, *(_lining(hole, depth) for hole in openings)])


def _lining(hole: Opening, depth: float) -> Shape:
    """The four faces of an opening's thickness, which run LAP past what closes it."""
    w, h, depth = hole.width, hole.height, depth + LAP
    left = quad((hole.left, hole.bottom, 0), (0, 0, -depth), (0, h, 0))
    right = quad((hole.right, hole.bottom, -depth), (0, 0, depth), (0, h, 0))
    top = quad((hole.left, hole.top, -depth), (w, 0, 0), (0, 0, depth))
    sill = quad((hole.left, hole.bottom, 0), (w, 0, 0), (0, 0, -depth))
    return join([left, right, top, sill])


def pane(hole: Opening, depth: float) -> Shape:
    """The face that closes an opening of wall() at the back of its lining, facing +Z."""
    return quad((hole.left, hole.bottom, -depth), (hole.width, 0, 0), (0, hole.height, 0))


def bands(hole: Opening, depth: float, heights: Sequence[Doubles]) -> list[Shape]:
    """The pane() cut into bands, bottom to top, by curves of as many `heights` (0 to 1) each, each above the last."""
    count = len(heights[0])
    x = np.linspace(hole.left, hole.right, count)
    levels = [hole.bottom + hole.height * share for share in (np.zeros(count), *heights, np.ones(count))]
    rows = [np.stack([x, y, np.full(count, -depth)], axis=1) for y in levels]
    return [surface([low, high]) for low, high in pairwise(rows)]


def window_frame(hole: Opening, z: float, columns: int, rows: int = 1, bar: float = 0.05, depth: float = 0.06) -> Shape:
    """A frame set into an opening of wall() around z, divided into `columns` × `rows` panes."""
    sink = 0.004  # the frame's rim goes into the lining, so that no faces coincide
    section = [
        (-sink, -depth / 2),
        (-sink, depth / 2),
        (bar - 0.006, depth / 2),
        (bar, depth / 2 - 0.006),
        (bar, -depth / 2),
    ]
    rim = moulding(section, rectangle((0, -hole.height), (hole.width, 0))).turned(90, "x")
    rim = rim.moved(hole.left, hole.bottom, z)
    xs = hole.left + hole.width * np.arange(1, columns) / columns
    ys = hole.bottom + hole.height * np.arange(1, rows) / rows
    upright = box((bar * 0.8, hole.height - bar, depth * 0.8), 0.005)
    level = box((hole.width - bar, bar * 0.8, depth * 0.7), 0.005)
    middle_x, middle_y = hole.left + hole.width / 2, hole.bottom + hole.height / 2
    return join([rim, *(upright.moved(x, middle_y, z) for x in xs), *(level.moved(middle_x, y, z) for y in ys)])


def venetian_blind(hole: Opening, z: float, tilt: float, pitch: float = 0.054) -> tuple[Shape, Shape]:
    """A blind of curved slats, turned by `tilt` degrees, that fills an opening around z: (slats and rails, cords)."""
    width = hole.width - 0.03
    arc = np.linspace(-0.5, 0.5, 7)
    x = np.linspace(-width / 2, width / 2, 9)
    section = np.stack([0.004 - 0.02 * arc**2, 0.062 * arc], axis=1)
    slat = surface(np.stack([np.stack([x, 0 * x + y, 0 * x - depth], axis=1) for y, depth in section]), 60.0)
    levels = np.arange(hole.bottom + 0.05, hole.top - 0.06, pitch)
    middle = hole.left + hole.width / 2
    places = np.stack([0 * levels + middle, levels, 0 * levels + z], axis=1)
    slats = copies(slat.turned(tilt, "x"), places)
    head = box((width, 0.04, 0.055), 0.004).moved(middle, hole.top - 0.0205, z)
    foot = box((width, 0.016, 0.05), 0.005).moved(middle, hole.bottom + 0.02, z)
    cords = [
        tube([(middle + side * width * 0.38, y, z + front) for y in (hole.bottom + 0.02, hole.top - 0.03)], 0.0012, 6)
        for side in (-1, 0, 1)
        for front in (-0.03, 0.03)
    ]
    return join([slats, head, foot]), join(cords)


def skirting(outline: ArrayLike, height: float = 0.09, thickness: float = 0.014, closed: bool = False) -> Shape:
    """A skirting board along a room's plan (counter-clockwise from above), its back 2 mm inside the walls."""
    section = [
        (-0.002, -0.002),
        (-0.002, height),
        (thickness * 0.5, height),
        (thickness, height - 0.012),
        (thickness, -0.002),
    ]
    return moulding(section, outline, closed)


def door(width: float, height: float) -> tuple[Shape, Shape, Shape]:
    """A closed panelled door in front of a wall at z = 0, facing +Z, its foot at the origin: (leaf, casing, handle)."""
    leaf = box((width, height - 0.01, 0.03), 0.003).moved(0, height / 2 + 0.002, 0.0)
    stile, rail = 0.12, 0.1
    panel_height = (height - 4 * rail) / 3
    section = [(-0.001, 0.01), (-0.001, 0.0255), (0.012, 0.022), (0.03, 0.0165), (0.03, 0.01)]
    rim = moulding(section, rectangle((-width / 2 + stile, -panel_height / 2), (width / 2 - stile, panel_height / 2)))
    ribs = [
        rim.turned(90, "x").moved(0, rail + panel_height / 2 + number * (panel_height + rail), 0) for number in range(3)
    ]
    casing = moulding(
        [(-0.08, -0.01), (-0.08, 0.014), (-0.05, 0.026), (0.0, 0.03), (0.0, -0.01)],
        [
            (width / 2 + 0.004, 0.002),
            (width / 2 + 0.004, -height),
            (-width / 2 - 0.004, -height),
            (-width / 2 - 0.004, 0.002),
        ],
        closed=False,
    ).turned(90, "x")
    plate = cylinder(0.026, 0.01, 24, 0.003).turned(90, "x").moved(0, 0, 0.0145)
    bent = rounded_path([(0, 0, 0.02), (0, 0, 0.065), (-0.13, 0, 0.065)], 0.02)
    handle = join([plate, tube(bent, 0.009, 14)]).moved(width / 2 - 0.07, 1.02, 0)
    return join([leaf, *ribs]), casing, handle


def picture_frame(width: float, height: float, bar: float = 0.035, depth: float = 0.028) -> Shape:
    """A frame around a picture of `width` × `height` metres in the plane z = 0.01, to hang on a wall at z = 0."""
    section = [
        (-bar, 0.0005),
        (-bar, depth * 0.8),
        (-bar * 0.7, depth),
        (-bar * 0.25, depth * 0.9),
        (0.004, 0.014),
        (0.004, 0.0005),
    ]
    return moulding(section, rectangle((-width / 2, -height / 2), (width / 2, height / 2))).turned(90, "x")


@dataclass(frozen=True)
class Placer:
    """A turn about the vertical in degrees, followed by a move; call it on a shape."""

    degrees: float
    offset: tuple[float, float, float]

    def __call__(self, shape: Shape) -> Shape:
        """`shape` where it belongs."""
        matrix = rotation(self.degrees, "y")
        return copies(shape, [self.offset], [matrix])

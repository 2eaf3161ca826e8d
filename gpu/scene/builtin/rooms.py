"""What rooms are made of: walls with openings, windows with blinds, doors, skirting boards, framed pictures."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import (
    box,
    cylinder,
    moulding,
    picture,
    points,
    quad,
    rectangle,
    rounded_path,
    surface,
    tube,
)
from gpu.scene.types import Bytes, Doubles

LAP = 0.01  # metres that floors, walls and ceilings run past each other, so that no light comes through the corners


class Opening(NamedTuple):
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
    faces = [
        quad((x, y, 0), (right - x, 0, 0), (0, top - y, 0)).mapped_uv(x, y)
        for x, right in pairwise(xs)
        for y, top in pairwise(ys)
        if not any(hole.left <= x < hole.right and hole.bottom <= y < hole.top for hole in openings)
    ]
    d = depth + LAP  # the lining runs past what closes the opening
    for hole in openings:
        (left, bottom, right, top), w, h = hole, hole.width, hole.height
        faces.append(quad((left, bottom, 0), (0, 0, -d), (0, h, 0)))
        faces.append(quad((right, bottom, -d), (0, 0, d), (0, h, 0)))
        faces.append(quad((left, top, -d), (w, 0, 0), (0, 0, d)))
        faces.append(quad((left, bottom, 0), (w, 0, 0), (0, 0, -d)))
    return join(faces)


def bands(hole: Opening, depth: float, heights: Sequence[Doubles]) -> list[Shape]:
    """The face that closes an opening of wall() at the back of its lining, cut into bands from bottom to top.

    The cuts are curves of as many `heights` (0 to 1) each, each above the last.
    """
    count = len(heights[0]) if heights else 2
    x = np.linspace(hole.left, hole.right, count)
    levels = [hole.bottom + hole.height * share for share in (np.zeros(count), *heights, np.ones(count))]
    rows = [np.stack([x, y, np.full(count, -depth)], axis=1) for y in levels]
    return [surface([low, high]) for low, high in pairwise(rows)]


def window_frame(hole: Opening, z: float, columns: int, bar: float = 0.05, depth: float = 0.06) -> Shape:
    """A frame set into an opening of wall() around z, divided into `columns` panes."""
    sink = 0.004  # the frame's rim goes into the lining, so that no faces coincide
    half, inner = depth / 2, bar - 0.006
    section = [(-sink, -half), (-sink, half), (inner, half), (bar, half - 0.006), (bar, -half)]
    rim = moulding(section, rectangle((0, -hole.height), (hole.width, 0))).turned(90, "x")
    upright = box((bar * 0.8, hole.height - bar, depth * 0.8), 0.005)
    xs = hole.left + hole.width * np.arange(1, columns) / columns
    bars = (upright.moved(x, hole.bottom + hole.height / 2, z) for x in xs)
    return join([rim.moved(hole.left, hole.bottom, z), *bars])


def sill(hole: Opening, overlap: float, depth: float) -> Shape:
    """The board under an opening of wall(), `overlap` wider than it."""
    board = box((hole.width + overlap, 0.03, depth), 0.008, 2)
    return board.moved(hole.left + hole.width / 2, hole.bottom - 0.0155, 0.05)


def venetian_blind(hole: Opening, z: float, tilt: float) -> tuple[Shape, Shape]:
    """A blind of curved slats, turned by `tilt` degrees, that fills an opening around z: (slats and rails, cords)."""
    width, middle = hole.width - 0.03, hole.left + hole.width / 2
    arc = np.linspace(-0.5, 0.5, 7)
    x = np.linspace(-width / 2, width / 2, 9)
    section = np.stack([0.004 - 0.02 * arc**2, 0.062 * arc], axis=1)
    slat = surface(np.stack([np.stack([x, 0 * x + y, 0 * x - depth], axis=1) for y, depth in section]), 60.0)
    slats = slat.turned(tilt, "x").at([(middle, y, z) for y in np.arange(hole.bottom + 0.05, hole.top - 0.06, 0.054)])
    head = box((width, 0.04, 0.055), 0.004).moved(middle, hole.top - 0.0205, z)
    foot = box((width, 0.016, 0.05), 0.005).moved(middle, hole.bottom + 0.02, z)
    cords = [
        tube([(middle + side * width * 0.38, y, z + front) for y in (hole.bottom + 0.02, hole.top - 0.03)], 0.0012, 6)
        for side in (-1, 0, 1)
        for front in (-0.03, 0.03)
    ]
    return join([slats, head, foot]), join(cords)


def skirting(outline: ArrayLike, height: float, closed: bool = False) -> Shape:
    """A skirting board along a room's plan (counter-clockwise from above), its back 2 mm inside the walls."""
    section = [(-0.002, -0.002), (-0.002, height), (0.007, height), (0.014, height - 0.012), (0.014, -0.002)]
    return moulding(section, outline, closed)


def door(width: float, height: float) -> tuple[Shape, Shape, Shape]:
    """A closed panelled door in front of a wall at z = 0, facing +Z, its foot at the origin: (leaf, casing, handle)."""
    leaf = box((width, height - 0.01, 0.03), 0.003).moved(0, height / 2 + 0.002, 0.0)
    half, stile, rail = width / 2, 0.12, 0.1
    panel = (height - 4 * rail) / 3
    section = points("-.001,.01 -.001,.0255 .012,.022 .03,.0165 .03,.01")
    rim = moulding(section, rectangle((-half + stile, -panel / 2), (half - stile, panel / 2))).turned(90, "x")
    ribs = [rim.moved(0, rail + panel / 2 + number * (panel + rail), 0) for number in range(3)]
    side = half + 0.004
    outline = [(side, 0.002), (side, -height), (-side, -height), (-side, 0.002)]
    casing = moulding(points("-.08,-.01 -.08,.014 -.05,.026 0,.03 0,-.01"), outline, closed=False).turned(90, "x")
    plate = cylinder(0.026, 0.01, 24, 0.003).turned(90, "x").moved(0, 0, 0.0145)
    bent = tube(rounded_path([(0, 0, 0.02), (0, 0, 0.065), (-0.13, 0, 0.065)], 0.02), 0.009, 14)
    return join([leaf, *ribs]), casing, join([plate, bent]).moved(width / 2 - 0.07, 1.02, 0)


def hang(builder: Builder, frame: str, image: Callable[[], Bytes], width: float, height: float) -> None:
    """A painting of `width` × `height` metres in a frame of that material, on a wall at z = 0, its middle there."""
    section = points("-.035,.0005 -.035,.0224 -.0245,.028 -.00875,.0252 .004,.014 .004,.0005")
    outline = rectangle((-width / 2, -height / 2), (width / 2, height / 2))
    builder.add(frame, moulding(section, outline).turned(90, "x"))
    builder.textured("painting", image, roughness=0.8)
    builder.add("painting", picture(width, height))

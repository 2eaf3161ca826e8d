"""Primitive shapes in metres, standing on or centred at the origin as each says; every front faces outwards."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from gpu.scene.builtin.shape import Shape, shaded
from gpu.scene.types import Doubles, Ints

Points = list[tuple[float, ...]]
# Along which axes the textures of a box's sides lie: level on those that are upright, and along x on top.
_TEXTURED = np.array([(2, 1), (0, 2), (0, 1)])


def points(text: str) -> Points:
    """The points of "x,y x,y …", as in an SVG path."""
    return [tuple(float(number) for number in point.split(",")) for point in text.split()]


def polar(angles: Doubles, x: Doubles | float, y: Doubles | float = 0.0) -> Doubles:
    """Points (…, 3) at `angles` about the Y axis, from +X towards −Z, at the distance `x` and height `y`."""
    return np.stack(np.broadcast_arrays(x * np.cos(angles), y, -x * np.sin(angles)), axis=-1)


def surface(grid: ArrayLike, crease: float = 35.0) -> Shape:
    """The points `grid` (row, column, 3); its front is where columns × rows points.

    UVs are lengths along the grid: u over the columns, v over the rows, each where that direction is longest.
    """
    grid = np.asarray(grid, np.float64)
    across = np.linalg.norm(np.diff(grid, axis=1), axis=2).max(axis=0)
    along = np.linalg.norm(np.diff(grid, axis=0), axis=2).max(axis=1)
    u, v = np.append(0.0, np.cumsum(across)), np.append(0.0, np.cumsum(along))
    uvs = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return shaded(grid.reshape(-1, 3), uvs, _grid_triangles(*grid.shape[:2]), crease)


def _grid_triangles(rows: int, columns: int) -> Ints:
    """Two triangles for each cell of a grid of points, as indices of its points in row order."""
    corner = (columns * np.arange(rows - 1, dtype=np.int32)[:, None] + np.arange(columns - 1)).reshape(-1, 1)
    cells = corner + np.array([0, 1, columns + 1, 0, columns + 1, columns])
    return np.asarray(cells.reshape(-1, 3), np.int32)


def quad(origin: ArrayLike, across: ArrayLike, along: ArrayLike) -> Shape:
    """A parallelogram with corner `origin` and edges `across` (u) and `along` (v); front: across × along."""
    corner, e, f = (np.asarray(vector, np.float64) for vector in (origin, across, along))
    return surface([[corner, corner + e], [corner + f, corner + e + f]])


def picture(width: float, height: float, z: float = 0.01) -> Shape:
    """An upright rectangle centred at (0, 0, z) that faces +Z and shows the whole of a texture, its row 0 on top."""
    shape = quad((-width / 2, height / 2, z), (0, -height, 0), (width, 0, 0))
    return replace(shape, uvs=shape.positions[:, :2] * (1 / width, -1 / height) + 0.5)


def block(low: ArrayLike, high: ArrayLike) -> Shape:
    """The sharp-edged box between corners `low` and `high`."""
    half, unit = np.subtract(high, low) / 2, _cube()
    uvs = unit.uvs * half[_TEXTURED[np.abs(unit.normals).argmax(axis=1)]]
    return replace(unit, positions=unit.positions * half, uvs=uvs).moved(*(np.add(low, high) / 2))


@cache
def _cube() -> Shape:
    """Two metres wide, centred at the origin."""
    return box((2.0, 2.0, 2.0), 0.0)


def box(size: ArrayLike, bevel: float = 0.004, segments: int = 1, fill: int = 1, bulge: float = 0.0) -> Shape:
    """A box of `size` (x, y, z) centred at the origin, its edges rounded with radius `bevel`.

    segments: of each eighth of a rounding's turn; fill: of each flat; bulge: how much the top and bottom swell in the
    middle (a cushion), in metres.
    """
    half = np.asarray(size, np.float64) / 2.0
    positions, uvs, triangles, start = [], [], [], 0
    for axis, side in ((axis, side) for axis in range(3) for side in (1, -1)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        lines = [_lines(half[other], bevel, segments, fill) for other in (u, v)]
        grid = np.empty((len(lines[1]), len(lines[0]), 3))
        grid[..., u], grid[..., v] = np.meshgrid(*lines)
        grid[..., axis] = side * half[axis]
        sharp = grid[:, ::side].reshape(-1, 3)
        inner = np.clip(sharp, -(half - bevel), half - bevel)
        out = sharp - inner
        reach = np.linalg.norm(out, axis=1, keepdims=True)
        positions.append(inner + out * (bevel / reach if bevel > 0.0 else 0.0))
        uvs.append(sharp[:, _TEXTURED[axis]] * (1.0, 1.0 if axis == 1 else -1.0))
        triangles.append(_grid_triangles(*grid.shape[:2]) + start)
        start += len(sharp)
    corners = np.concatenate(positions)
    if bulge:
        x, z = corners[:, 0] / half[0], corners[:, 2] / half[2]
        corners[:, 1] += np.sign(corners[:, 1]) * bulge * (1 - x * x) * (1 - z * z)
    return shaded(corners, np.concatenate(uvs), np.concatenate(triangles), 50.0)


def _lines(half: float, bevel: float, segments: int, fill: int) -> Doubles:
    """Where grid lines of a box's face lie, so that they spread evenly over the roundings."""
    if bevel <= 0.0:
        return np.linspace(-half, half, fill + 1)
    turn = bevel * np.tan(np.linspace(0.0, pi / 4, segments + 1)) + half - bevel
    return np.concatenate([-turn[:0:-1], np.linspace(-turn[0], turn[0], fill + 1), turn[1:]])


def lathe(profile: ArrayLike, sides: int = 32, crease: float = 35.0) -> Shape:
    """`profile` (point, 2) of (radius, y) turned about the Y axis; bottom to top for a front that faces outwards."""
    radius, y = np.asarray(profile, np.float64).T[:, :, None]
    return surface(polar(2 * pi * (np.arange(sides + 1) % sides) / sides, radius, y), crease)


def cylinder(radius: float, height: float, sides: int = 32, bevel: float = 0.0) -> Shape:
    """An upright closed cylinder that stands on the origin."""
    rim = [(radius - bevel, 0), (radius, bevel), (radius, height - bevel), (radius - bevel, height)]
    return lathe([(0, 0), *(rim if bevel else rim[1:3]), (0, height)], sides)


def sphere(radius: float, sides: int = 32) -> Shape:
    """A sphere centred at the origin."""
    angle = np.linspace(-pi / 2, pi / 2, sides // 2 + 1)
    profile = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    profile[[0, -1], 0] = 0.0
    return lathe(profile, sides, 60.0)


def tube(path: ArrayLike, radius: ArrayLike, sides: int = 10) -> Shape:
    """A round bar along `path` (point, 3) with `radius` (one or one a point), capped at its ends."""
    line = np.asarray(path, np.float64)
    tangents = np.concatenate([line[1:], line[-1:]]) - np.concatenate([line[:1], line[:-1]])
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    # Carry one normal along the path with as little twist as can be.
    normal = np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])
    normals = np.empty_like(line)
    for number, tangent in enumerate(tangents):
        normal = normal - tangent * (tangent @ normal)
        normals[number] = normal = normal / np.linalg.norm(normal)
    angle = (2 * pi * (np.arange(sides + 1) % sides) / sides)[:, None]
    around = np.cos(angle) * normals[:, None] + np.sin(angle) * np.cross(tangents, normals)[:, None]
    rings = line[:, None] + np.broadcast_to(radius, len(line))[:, None, None] * around
    first, last = (np.repeat(end[None, None], sides + 1, axis=1) for end in (line[0], line[-1]))
    return surface(np.concatenate([first, rings, last]), 60.0)


def rounded_path(corners: ArrayLike, radius: float, steps: int = 6) -> Doubles:
    """A polyline (point, 3) whose inner corners are replaced by quadratic curves that begin `radius` before them."""
    line = np.asarray(corners, np.float64)
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    path = [line[:1]]
    for before, corner, after in zip(line[:-2], line[1:-1], line[2:], strict=True):
        start, end = (corner + radius * (p - corner) / np.linalg.norm(p - corner) for p in (before, after))
        path.append((1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t**2 * end)
    return np.concatenate([*path, line[-1:]])


def slab(outline: Doubles, height: float, bevel: float = 0.0, segments: int = 2) -> Shape:
    """A plate between y = 0 and `height` over the star-shaped `outline` (point, 2) of (x, z), edges rounded.

    The outline runs counter-clockwise seen from above, that is from +X towards −Z.
    """
    turn = np.linspace(0.0, pi / 2, segments + 1)
    inset, rise = bevel * (1 - np.sin(turn)), bevel * (1 - np.cos(turn))
    levels = list(zip(inset, rise, strict=True)) if bevel else [(0.0, 0.0)]
    levels += [(d, height - h) for d, h in reversed(levels)]
    rings = [_offset(outline, d, h) for d, h in levels]
    bottom, top = (np.broadcast_to(ring[:-1].mean(axis=0), ring.shape) for ring in (rings[0], rings[-1]))
    shape = surface(np.stack([bottom, *rings, top]))
    level = np.abs(shape.normals[:, 1:2]) > 0.7
    return replace(shape, uvs=np.where(level, shape.positions[:, [0, 2]], shape.uvs))


def moulding(section: Sequence[Sequence[float]] | Doubles, outline: ArrayLike, closed: bool = True) -> Shape:
    """A bar of profile `section` (point, 2) of (inset, y) along the plan `outline` (point, 2) of (x, z), mitred.

    The outline runs counter-clockwise seen from above and insets go to its left, towards the middle of a room or a
    frame. The section, drawn with the inset to the right, runs clockwise: over the top from the wall to the middle.
    """
    plan = np.asarray(outline, np.float64)
    rows = [_offset(plan, inset, y, closed) for inset, y in section]
    return surface(np.stack([*rows, rows[0]]), 30.0)


def _offset(plan: Doubles, distance: float, y: float, closed: bool = True) -> Doubles:
    """`plan` (point, 2) of (x, z) at height `y`, each edge moved `distance` to its left, seen from above."""
    ahead, behind = np.roll(plan, -1, axis=0) - plan, plan - np.roll(plan, 1, axis=0)
    if not closed:
        ahead[-1], behind[0] = behind[-1], ahead[0]
    left = [
        np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None] for edge in (ahead, behind)
    ]
    mitre = left[0] + left[1]
    plan = plan + 2.0 * distance * mitre / np.einsum("pc,pc->p", mitre, mitre)[:, None]
    ring = np.insert(plan, 1, y, axis=1)
    return np.concatenate([ring, ring[:1]]) if closed else ring


def rectangle(low: Sequence[float], high: Sequence[float]) -> Doubles:
    """The plan (4, 2) of the rectangle between (x, z) corners, counter-clockwise seen from above."""
    return np.array([(low[0], high[1]), (high[0], high[1]), (high[0], low[1]), (low[0], low[1])], np.float64)


def superellipse(x: float, z: float, power: float, count: int = 64) -> Doubles:
    """The plan (count, 2) of |x/a|^p + |z/b|^p = 1 with half axes `x` and `z`, counter-clockwise seen from above."""
    angle = 2 * pi * np.arange(count) / count
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([x * np.sign(c) * np.abs(c) ** (2 / power), -z * np.sign(s) * np.abs(s) ** (2 / power)], axis=1)

"""Primitive shapes in metres, standing on or centred at the origin as each says; every front faces outwards."""

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from gpu.scene.builtin.shape import Shape, shaded
from gpu.scene.types import Doubles, Ints

Point = Sequence[float]


def surface(points: ArrayLike, crease: float = 35.0) -> Shape:
    """The grid `points` (row, column, 3); its front is where columns × rows points.

    UVs are lengths along the grid: u over the columns, v over the rows, each where that direction is longest.
    """
    grid = np.asarray(points, np.float64)
    rows, columns = grid.shape[:2]
    across = np.linalg.norm(np.diff(grid, axis=1), axis=2).max(axis=0)
    along = np.linalg.norm(np.diff(grid, axis=0), axis=2).max(axis=1)
    u, v = np.append(0.0, np.cumsum(across)), np.append(0.0, np.cumsum(along))
    uvs = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return shaded(grid.reshape(-1, 3), uvs, _grid_triangles(rows, columns), crease)


def _grid_triangles(rows: int, columns: int) -> Ints:
    """Two triangles for each cell of a grid of points, as indices of its points in row order."""
    corner: Ints = (columns * np.arange(rows - 1, dtype=np.int32)[:, None] + np.arange(columns - 1)).reshape(-1)
    cells = np.stack([corner, corner + 1, corner + columns + 1, corner, corner + columns + 1, corner + columns], axis=1)
    return np.asarray(cells.reshape(-1, 3), np.int32)


def quad(origin: Point, across: Point, along: Point) -> Shape:
    """A parallelogram with corner `origin` and edges `across` (u) and `along` (v); front: across × along."""
    corner, e, f = (np.asarray(vector, np.float64) for vector in (origin, across, along))
    return surface([[corner, corner + e], [corner + f, corner + e + f]])


def picture(width: float, height: float) -> Shape:
    """An upright rectangle centred at the origin that faces +Z and shows the whole of a texture, its row 0 on top."""
    shape = quad((-width / 2, height / 2, 0), (0, -height, 0), (width, 0, 0))
    uvs = shape.positions[:, :2] * (1 / width, -1 / height) + 0.5
    return Shape(shape.positions, shape.triangles, shape.normals, uvs)


def block(low: Point, high: Point) -> Shape:
    """The sharp-edged box between corners `low` and `high`."""
    return box(np.subtract(high, low).tolist(), 0.0).moved(*((np.add(low, high)) / 2))


def box(size: Point, bevel: float = 0.004, segments: int = 1, fill: int = 1, bulge: float = 0.0) -> Shape:
    """A box of `size` (x, y, z) centred at the origin, its edges rounded with radius `bevel`.

    segments: of each eighth of a rounding's turn; fill: of each flat; bulge: how much the top and bottom swell in the
    middle (a cushion), in metres.
    """
    half = np.asarray(size, np.float64) / 2.0
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        lines = [_lines(half[other], bevel, segments, fill) for other in (u, v)]
        grid = np.empty((len(lines[1]), len(lines[0]), 3))
        grid[..., u], grid[..., v] = np.meshgrid(lines[0], lines[1])
        grid[..., axis] = half[axis]
        mirrored = (grid * np.where(np.arange(3) == axis, -1.0, 1.0))[:, ::-1]
        faces += [(grid, axis), (mirrored, axis)]
    positions, uvs, triangles, start = [], [], [], 0
    for grid, axis in faces:
        sharp = grid.reshape(-1, 3)
        inner = np.clip(sharp, -(half - bevel), half - bevel)
        out = sharp - inner
        reach = np.linalg.norm(out, axis=1, keepdims=True)
        positions.append(inner + out * (bevel / reach if bevel > 0.0 else 0.0))
        # Textures lie level on the sides and along x on top.
        flat = {0: (2, 1), 1: (0, 2), 2: (0, 1)}[axis]
        uvs.append(sharp[:, flat] * (1.0, 1.0 if axis == 1 else -1.0))
        triangles.append(_grid_triangles(*grid.shape[:2]) + start)
        start += len(sharp)
    points = np.concatenate(positions)
    if bulge:
        x, z = points[:, 0] / half[0], points[:, 2] / half[2]
        points[:, 1] += np.sign(points[:, 1]) * bulge * (1 - x * x) * (1 - z * z)
    return shaded(points, np.concatenate(uvs), np.concatenate(triangles), 50.0)


def _lines(half: float, bevel: float, segments: int, fill: int) -> Doubles:
    """Where grid lines of a box's face lie, so that they spread evenly over the roundings."""
    if bevel <= 0.0:
        return np.linspace(-half, half, fill + 1)
    turn = bevel * np.tan(np.linspace(0.0, pi / 4, segments + 1)) + half - bevel
    return np.concatenate([-turn[:0:-1], np.linspace(-turn[0], turn[0], fill + 1), turn[1:]])


def lathe(profile: Sequence[Point], sides: int = 32, crease: float = 35.0) -> Shape:
    """The profile of (radius, y) points, bottom to top for a front that faces outwards, turned about the Y axis."""
    radius, y = np.asarray(profile, np.float64).T
    angle = 2 * pi * (np.arange(sides + 1) % sides) / sides
    ring = np.stack([np.cos(angle), np.zeros(sides + 1), -np.sin(angle)], axis=1)
    return surface(radius[:, None, None] * ring + np.stack([0 * y, y, 0 * y], axis=1)[:, None], crease)


def cylinder(radius: float, height: float, sides: int = 32, bevel: float = 0.0) -> Shape:
    """An upright closed cylinder that stands on the origin."""
    rim = [(radius - bevel, 0), (radius, bevel), (radius, height - bevel), (radius - bevel, height)]
    return lathe([(0, 0), *(rim if bevel else rim[1:3]), (0, height)], sides)


def sphere(radius: float, sides: int = 32) -> Shape:
    """A sphere centred at the origin."""
    angle = np.linspace(-pi / 2, pi / 2, sides // 2 + 1)
    profile = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    profile[[0, -1], 0] = 0.0
    return lathe(profile.tolist(), sides, 60.0)


def tube(path: ArrayLike, radius: float | ArrayLike, sides: int = 10, closed: bool = False) -> Shape:
    """A round bar along `path` (point, 3) with `radius` (one or one a point), capped at its ends unless `closed`."""
    points = np.asarray(path, np.float64)
    ahead, behind = np.roll(points, -1, axis=0), np.roll(points, 1, axis=0)
    if not closed:
        ahead[-1], behind[0] = points[-1], points[0]
    tangents = ahead - behind
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    # Carry one normal along the path with as little twist as can be.
    normal = np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])
    normals = np.empty_like(points)
    for number, tangent in enumerate(tangents):
        normal = normal - tangent * (tangent @ normal)
        normal /= np.linalg.norm(normal)
        normals[number] = normal
    angle = 2 * pi * (np.arange(sides + 1) % sides) / sides
    around = np.cos(angle)[:, None] * normals[:, None] + np.sin(angle)[:, None] * np.cross(tangents, normals)[:, None]
    rings = points[:, None] + np.broadcast_to(np.asarray(radius, np.float64), len(points))[:, None, None] * around
    if closed:
        return surface(np.concatenate([rings, rings[:1]]), 60.0)
    ends = [np.repeat(point[None, None], sides + 1, axis=1) for point in (points[0], points[-1])]
    return surface(np.concatenate([ends[0], rings, ends[1]]), 60.0)


def rounded_path(corners: ArrayLike, radius: float, steps: int = 6, closed: bool = False) -> Doubles:
    """A polyline (point, 3) whose corners are replaced by quadratic curves that begin `radius` before them."""
    points = np.asarray(corners, np.float64)
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    path = []
    for number, corner in enumerate(points):
        if not closed and number in (0, len(points) - 1):
            path.append(corner[None])
            continue
        before, after = points[number - 1], points[(number + 1) % len(points)]
        start, end = (corner + radius * (p - corner) / np.linalg.norm(p - corner) for p in (before, after))
        path.append((1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t**2 * end)
    return np.concatenate(path)


def slab(outline: ArrayLike, height: float, bevel: float = 0.0, segments: int = 2) -> Shape:
    """A plate between y = 0 and `height` over the star-shaped `outline` (point, 2) of (x, z), edges rounded.

    The outline runs counter-clockwise seen from above, that is from +X towards −Z.
    """
    turn = np.linspace(0.0, pi / 2, segments + 1)
    inset, rise = bevel * (1 - np.sin(turn)), bevel * (1 - np.cos(turn))
    levels = [(d, h) for d, h in zip(inset, rise, strict=True)] if bevel else [(0.0, 0.0)]
    levels += [(d, height - h) for d, h in reversed(levels)]
    rings = [_ring(_inset(np.asarray(outline, np.float64), d), h) for d, h in levels]
    centres = [np.broadcast_to(ring[:-1].mean(axis=0), ring.shape) for ring in (rings[0], rings[-1])]
    shape = surface(np.stack([centres[0], *rings, centres[1]]))
    level = np.abs(shape.normals[:, 1]) > 0.7
    uvs = np.where(level[:, None], shape.positions[:, [0, 2]], shape.uvs)
    return Shape(shape.positions, shape.triangles, shape.normals, uvs)


def moulding(section: ArrayLike, outline: ArrayLike, closed: bool = True) -> Shape:
    """A bar of profile `section` (point, 2) of (inset, y) along the plan `outline` (point, 2) of (x, z), mitred.

    The outline runs counter-clockwise seen from above and insets go to its left, towards the middle of a room or a
    frame. The section, drawn with the inset to the right, runs clockwise: over the top from the wall to the middle.
    """
    plan = np.asarray(outline, np.float64)
    offsets = np.asarray(section, np.float64)
    rows = [_ring(_inset(plan, inset, closed), y, closed) for inset, y in offsets]
    return surface(np.stack([*rows, rows[0]]), 30.0)


def _ring(plan: Doubles, y: float, closed: bool = True) -> Doubles:
    points = np.insert(plan, 1, y, axis=1)
    return np.concatenate([points, points[:1]]) if closed else points


def _inset(plan: Doubles, distance: float, closed: bool = True) -> Doubles:
    """`plan` (point, 2) of (x, z) with each edge moved `distance` to its left, seen from above."""
    ahead, behind = np.roll(plan, -1, axis=0) - plan, plan - np.roll(plan, 1, axis=0)
    if not closed:
        ahead[-1], behind[0] = behind[-1], ahead[0]
    left = [
        np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None] for edge in (ahead, behind)
    ]
    mitre = left[0] + left[1]
    return plan + 2.0 * distance * mitre / np.einsum("pc,pc->p", mitre, mitre)[:, None]


def rectangle(low: Point, high: Point) -> Doubles:
    """The plan (4, 2) of the rectangle between (x, z) corners, counter-clockwise seen from above."""
    return np.array([(low[0], high[1]), (high[0], high[1]), (high[0], low[1]), (low[0], low[1])], np.float64)


def superellipse(x: float, z: float, power: float, count: int) -> Doubles:
    """The plan (count, 2) of |x/a|^p + |z/b|^p = 1 with half axes `x` and `z`, counter-clockwise seen from above."""
    angle = 2 * pi * np.arange(count) / count
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([x * np.sign(c) * np.abs(c) ** (2 / power), -z * np.sign(s) * np.abs(s) ** (2 / power)], axis=1)

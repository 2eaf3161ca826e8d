"""UsdGeom's shapes — cube, sphere, cylinder, cone, capsule, plane — as triangles."""

from math import pi, sin
from typing import Any

import numpy as np
from pxr import UsdGeom

from gpu.scene.formats.usd.stage import Stage
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles

SEGMENTS = 48
"""Around a round shape. Its radius is a little larger, so that it has the round one's area."""

SHAPES = (UsdGeom.Cube, UsdGeom.Sphere, UsdGeom.Cylinder, UsdGeom.Cone, UsdGeom.Capsule, UsdGeom.Plane)
_TURNS = {
    "X": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "Z": np.eye(3),
}


def shape_of(stage: Stage, prim: Any) -> MeshPart:
    """The shape `prim` around its own origin."""

    def number(name: str) -> float:
        return float(prim.GetAttribute(name).Get(stage.time))

    if prim.IsA(UsdGeom.Cube):
        return box(number("size"))
    if prim.IsA(UsdGeom.Sphere):
        return revolved([arc(number("radius"))])
    axis = str(prim.GetAttribute("axis").Get(stage.time))
    if prim.IsA(UsdGeom.Plane):
        return turned(rectangle(number("width"), number("length")), axis)
    radius, top = number("radius"), number("height") / 2.0
    if prim.IsA(UsdGeom.Capsule):
        low, high = arc(radius, -pi / 2.0, 0.0), arc(radius, 0.0, pi / 2.0)
        lift = np.array([0.0, top, 0.0, 0.0])
        return turned(revolved([np.concatenate([low - lift, high + lift])]), axis)
    bottom = disc(radius, -top, -1.0)
    if prim.IsA(UsdGeom.Cylinder):
        return turned(revolved([bottom, tube(radius, top), disc(radius, top, 1.0)]), axis)
    slope = np.array([2.0 * top, radius]) / max(float(np.hypot(2.0 * top, radius)), 1e-30)
    side = np.array([[radius, -top, *slope], [0.0, top, *slope]])
    return turned(revolved([bottom, side]), axis)


def tube(radius: float, top: float) -> Doubles:
    """The outline of a cylinder's side, from -top to top."""
    return np.array([[radius, -top, 1.0, 0.0], [radius, top, 1.0, 0.0]])


def disc(radius: float, height: float, up: float) -> Doubles:
    """The outline of a flat disc that faces up (1) or down (-1)."""
    outline = np.array([[radius, height, 0.0, up], [0.0, height, 0.0, up]])
    return outline if up > 0.0 else outline[::-1]


def arc(radius: float, start: float = -pi / 2.0, end: float = pi / 2.0) -> Doubles:
    """The outline of a sphere between two latitudes [rad]."""
    angles = np.linspace(start, end, SEGMENTS // 2 + 1)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([radius * unit, unit], axis=1)


def revolved(outlines: list[Doubles]) -> MeshPart:
    """A surface around Z from outlines (point, 4) — radius, z and their normal — each drawn from low to high z."""
    angles = np.arange(SEGMENTS) * 2.0 * pi / SEGMENTS
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    step = 2.0 * pi / SEGMENTS
    wider = (step / sin(step)) ** 0.5  # a regular polygon's area to a circle's
    positions, normals, triangles, start = [], [], [], 0
    for outline in outlines:
        for radius, z, nr, nz in outline:
            positions.append(np.column_stack([ring * radius * wider, np.full(SEGMENTS, z)]))
            normals.append(np.column_stack([ring * nr, np.full(SEGMENTS, nz)]))
        for row in range(len(outline) - 1):
            here = start + row * SEGMENTS + np.arange(SEGMENTS)
            after = start + row * SEGMENTS + (np.arange(SEGMENTS) + 1) % SEGMENTS
            if outline[row, 0] > 1e-9 * abs(outline[:, 0]).max():
                triangles.append(np.stack([here, after, after + SEGMENTS], axis=1))
            if outline[row + 1, 0] > 1e-9 * abs(outline[:, 0]).max():
                triangles.append(np.stack([here, after + SEGMENTS, here + SEGMENTS], axis=1))
        start += len(outline) * SEGMENTS
    return MeshPart(np.concatenate(positions), np.concatenate(triangles), np.concatenate(normals))


def rectangle(width: float, length: float) -> MeshPart:
    """A rectangle in the XY plane that faces +Z."""
    corners = np.array([[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]])
    return MeshPart(corners * (width, length, 1.0), np.array([[0, 1, 2], [0, 2, 3]]), np.tile([0.0, 0.0, 1.0], (4, 1)))


def box(size: float) -> MeshPart:
    """A cube around the origin."""
    face, lift = rectangle(size, size), np.array([0.0, 0.0, size / 2.0])
    front = MeshPart(face.positions + lift, face.triangles, face.normals)
    sides = [turned(side, axis) for axis in _TURNS for side in (front, _rotated(front, np.diag([-1.0, 1.0, -1.0])))]
    return MeshPart(
        np.concatenate([side.positions for side in sides]),
        np.concatenate([face.triangles + 4 * number for number in range(len(sides))]),
        np.concatenate([side.normals for side in sides if side.normals is not None]),
    )


def turned(part: MeshPart, axis: str) -> MeshPart:
    """`part` with its Z along the axis "X", "Y" or "Z"."""
    return _rotated(part, _TURNS[axis])


def _rotated(part: MeshPart, turn: Doubles) -> MeshPart:
    normals = None if part.normals is None else part.normals @ turn.T
    return MeshPart(part.positions @ turn.T, part.triangles, normals)

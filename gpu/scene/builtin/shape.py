"""A triangle mesh under construction: moved, turned, copied and joined, with normals that follow its creases."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import cos, radians, sin

import numpy as np
from numpy.typing import ArrayLike

from gpu.scene.types import Doubles, Ints

_CELL = 1e-5  # metres; points of one shape closer than this share a smooth normal


@dataclass(frozen=True, eq=False)
class Shape:
    """positions (vertex, 3) in metres, triangles (triangle, 3) counter-clockwise from the front, normals (vertex, 3)
    of unit length, uvs (vertex, 2) in metres along the surface, so that a texture has the same scale everywhere.
    """

    positions: Doubles
    triangles: Ints
    normals: Doubles
    uvs: Doubles

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> "Shape":
        """The shape shifted by (x, y, z) metres."""
        return replace(self, positions=self.positions + np.array([x, y, z]))

    def turned(self, degrees: float, axis: str = "y") -> "Shape":
        """The shape rotated about a coordinate axis ("x", "y" or "z"), counter-clockwise seen from its tip."""
        matrix = rotation(degrees, axis)
        return replace(self, positions=self.positions @ matrix.T, normals=self.normals @ matrix.T)

    def mirrored(self, axis: int) -> "Shape":
        """The shape's mirror image in the plane where coordinate `axis` is 0; fronts stay fronts."""
        flip = np.where(np.arange(3) == axis, -1.0, 1.0)
        return Shape(self.positions * flip, self.triangles[:, ::-1], self.normals * flip, self.uvs)

    def mapped_uv(self, u: float = 0.0, v: float = 0.0, swap: bool = False) -> "Shape":
        """The shape with its UVs swapped (a texture turned by 90°), then shifted by (u, v)."""
        return replace(self, uvs=(self.uvs[:, ::-1] if swap else self.uvs) + np.array([u, v]))

    def at(self, places: ArrayLike, degrees: ArrayLike = 0.0, uv_shifts: ArrayLike = 0.0) -> "Shape":
        """One copy at each of `places` (copy, 3), first turned about the vertical by `degrees` (copy,).

        uv_shifts: (copy, 2) added to the UVs, so that copies do not show the same piece of a texture.
        """
        where = np.reshape(places, (-1, 3))
        turns = [rotation(angle) for angle in np.broadcast_to(degrees, len(where))]
        return self.copies(where, np.reshape(turns, (-1, 3, 3)), uv_shifts)

    def copies(self, places: ArrayLike, matrices: Doubles, uv_shifts: ArrayLike = 0.0) -> "Shape":
        """One copy at each of `places` (copy, 3), first multiplied by its matrix in `matrices` (copy, 3, 3)."""
        where = np.asarray(places, np.float64).reshape(-1, 1, 3)
        count, turn = len(where), matrices.transpose(0, 2, 1)
        starts = len(self.positions) * np.arange(count, dtype=np.int32)
        return Shape(
            (self.positions @ turn + where).reshape(-1, 3),
            (self.triangles + starts[:, None, None]).reshape(-1, 3),
            (self.normals @ turn).reshape(-1, 3),
            (self.uvs + np.broadcast_to(uv_shifts, (count, 2))[:, None]).reshape(-1, 2),
        )


def rotation(degrees: float, axis: str = "y") -> Doubles:
    """The 3×3 matrix that turns column vectors about `axis`."""
    c, s = cos(radians(degrees)), sin(radians(degrees))
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[[first, first, second, second], [first, second, first, second]] = c, -s, s, c
    return matrix


def join(shapes: Iterable[Shape]) -> Shape:
    """All of `shapes` as one."""
    parts = list(shapes)
    starts = np.cumsum([0, *(len(part.positions) for part in parts)], dtype=np.int32)
    return Shape(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=False)]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.uvs for part in parts]),
    )


def shaded(positions: Doubles, uvs: Doubles, triangles: Ints, crease: float = 35.0) -> Shape:
    """A shape whose normals are smooth where faces meet at less than `crease` degrees and split elsewhere.

    A normal is the area-weighted mean of the faces around the vertex that lie within `crease` of the corner's own face,
    which keeps the flats beside a bevel flat. Triangles without an area are left out.
    """
    edges = positions[triangles]
    area = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
    length = np.linalg.norm(area, axis=1)
    solid = length > 1e-12
    triangles, area, length = triangles[solid], area[solid], length[solid]
    face, unit = np.repeat(area, 3, axis=0), np.repeat(area / length[:, None], 3, axis=0)

    # All pairs of corners that meet in one point.
    cell = np.round((positions - positions.min(axis=0)) / _CELL).astype(np.int64)
    corner = triangles.reshape(-1)
    key = (cell @ np.array([1 << 42, 1 << 21, 1]))[corner]
    order = np.argsort(key, kind="stable")
    _, start, count = np.unique(key[order], return_index=True, return_counts=True)
    per_corner = np.repeat(count, count)
    first = np.repeat(np.arange(len(order)), per_corner)
    offset = np.arange(len(first)) - np.repeat(np.cumsum(per_corner) - per_corner, per_corner)
    first, second = order[first], order[np.repeat(np.repeat(start, count), per_corner) + offset]
    near = np.einsum("pc,pc->p", unit[first], unit[second]) > cos(radians(crease))
    first, second = first[near], second[near]
    normals = np.stack([np.bincount(first, face[second, axis], len(corner)) for axis in range(3)], axis=1)
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]

    # Corners of one vertex with one normal become one vertex again.
    packed = np.round(normals * 500.0).astype(np.int64) + 512
    identity = (packed @ np.array([1 << 20, 1 << 10, 1])) + (corner.astype(np.int64) << 30)
    _, kept, index = np.unique(identity, return_index=True, return_inverse=True)
    return Shape(positions[corner[kept]], index.reshape(-1, 3).astype(np.int32), normals[kept], uvs[corner[kept]])


def warped(shape: Shape, positions: Doubles, crease: float = 50.0) -> Shape:
    """`shape` with its vertices at `positions` (vertex, 3) instead, and normals to match."""
    return shaded(positions, shape.uvs, shape.triangles, crease)

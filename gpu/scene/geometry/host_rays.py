"""Rays against triangles without a device, for the few that a default needs to be checked."""

import numpy as np

from gpu.scene.geometry.normals import area_vectors, unit_rows
from gpu.scene.types import AlphaMode, Doubles, Floats, Integers, Mask, Scene

# Shares of a triangle by which rounding may lose a ray at its edges.
_WIDER = 1e-6


class HostRays:
    """Triangles (triangle, 3) of vertices (vertex, 3), to be met one ray at a time."""

    def __init__(self, vertices: Doubles | Floats, triangles: Integers) -> None:
        self._vertices, self._triangles = vertices, triangles
        corners = [vertices.take(triangles[:, corner], axis=0) for corner in range(3)]
        middle = (corners[0] + corners[1] + corners[2]) / 3.0
        reach = np.maximum.reduce([_squares(corner - middle) for corner in corners])
        self._within = reach * 1.01 + 1e-12
        self._middle = middle.astype(np.float64)
        self._square = _squares(self._middle)

    def normal(self, face: int) -> Doubles:
        """The unit normal (3,) of a triangle, on the side that sees its corners counter-clockwise."""
        return unit_rows(area_vectors(self._vertices.astype(np.float64), self._triangles[face : face + 1]))[0][0]

    def first(self, origin: Doubles, direction: Doubles, culled: Mask | None = None) -> tuple[float, int]:
        """Distance and number of the first triangle along a unit `direction`, infinity and −1 where there is none.

        culled (triangle,): those that are not met from behind.
        """
        along = self._middle @ direction - origin @ direction
        aside = self._square - self._middle @ (2.0 * origin) + origin @ origin - along * along
        near = aside <= self._within
        near &= (along >= 0.0) | (along * along <= self._within)
        which = np.flatnonzero(near)
        corner, second, third = (self._vertices[self._triangles[which, k]].astype(np.float64).T for k in range(3))
        edge, other = second - corner, third - corner
        across = _cross(direction, other)
        determinant = _dot(edge, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            start = origin[:, None] - corner
            u = _dot(start, across) / determinant
            turned = _cross(start, edge)
            v = _dot(turned, direction) / determinant
            t = _dot(turned, other) / determinant
            met = (u >= -_WIDER) & (v >= -_WIDER) & (u + v <= 1.0 + _WIDER) & (t > 1e-6)
        if culled is not None:
            met &= ~culled[which] | (determinant > 0.0)
        if not met.any():
            return float("inf"), -1
        distance = np.where(met, t, np.inf)
        nearest = int(np.argmin(distance))
        return float(distance[nearest]), int(which[nearest])


def solid_triangles(scene: Scene) -> Mask:
    """Which triangles (triangle,) of a scene stop light: none of a sky, of clear glass or of a faint alpha."""
    solid = [
        not (material.backdrop or material.is_clear)
        and (material.alpha_mode is AlphaMode.OPAQUE or material.base_color[3] >= material.solid_alpha)
        for material in scene.materials
    ]
    return np.array(solid)[scene.triangle_material]


def _squares(rows: Doubles | Floats) -> Doubles:
    """The squared lengths (row,) of `rows` (row, 3)."""
    return np.asarray(np.einsum("rc,rc->r", rows, rows), np.float64)


def _dot(a: Doubles, b: Doubles) -> Doubles:
    """The products of vectors that lie a column at a time, (3, …)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _cross(a: Doubles, b: Doubles) -> Doubles:
    """As `np.cross`, of vectors as those of `_dot`, of which it takes several times as long for few."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])

"""Rays against triangles without a device, for the few that a default needs to be checked."""

import numpy as np

from gpu.scene.boxes import lengths, middles
from gpu.scene.normals import area_vectors
from gpu.scene.types import Doubles, Floats, Integers, Mask

# Shares of a triangle by which rounding may lose a ray at its edges.
_WIDER = 1e-6


class HostRays:
    """Triangles (triangle, 3) of vertices (vertex, 3), to be met one ray at a time."""

    def __init__(self, vertices: Doubles | Floats, triangles: Integers) -> None:
        vertices = vertices.astype(np.float64)
        corners = [vertices.take(triangles[:, k], axis=0) for k in range(3)]
        self._corner, self._edges = corners[0], (corners[1] - corners[0], corners[2] - corners[0])
        self._middle = middles(vertices, triangles)
        self._square = np.einsum("tc,tc->t", self._middle, self._middle)
        self._radius = np.maximum.reduce([lengths(corner - self._middle) for corner in corners])
        self._within = (1.001 * self._radius) ** 2 + 1e-12
        self.normals = area_vectors(vertices, triangles)

    def first(self, origin: Doubles, direction: Doubles, culled: Mask | None = None) -> tuple[float, int]:
        """Distance and number of the first triangle along a unit `direction`, infinity and −1 where there is none.

        culled (triangle,): those that are not met from behind.
        """
        along = self._middle @ direction - origin @ direction
        aside = self._square - self._middle @ (2.0 * origin) + origin @ origin - along * along
        near = (aside <= self._within) & (along >= -self._radius)
        if culled is not None:
            near &= ~culled | (self.normals @ direction < 0.0)
        which = np.flatnonzero(near)
        edge, other = (edges[which] for edges in self._edges)
        across = np.cross(direction, other)
        determinant = np.einsum("tc,tc->t", edge, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            start = origin - self._corner[which]
            u = np.einsum("tc,tc->t", start, across) / determinant
            turned = np.cross(start, edge)
            v = turned @ direction / determinant
            t = np.einsum("tc,tc->t", turned, other) / determinant
            met = (u >= -_WIDER) & (v >= -_WIDER) & (u + v <= 1.0 + _WIDER) & (t > 1e-6)
        if not met.any():
            return float("inf"), -1
        distance = np.where(met, t, np.inf)
        nearest = int(np.argmin(distance))
        return float(distance[nearest]), int(which[nearest])

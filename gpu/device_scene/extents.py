"""How far a scene reaches, kept by blocks of vertices, so that few are looked at where few have moved."""

import numpy as np

from gpu.scene.types import Floats, Mask, Scene

BLOCK = 1024  # vertices


def solid_vertices(scene: Scene) -> Mask | None:
    """Which vertices (vertex,) light can meet: not those of a backdrop alone. None: all of them."""
    backdrop = np.array([material.backdrop for material in scene.materials])
    if not backdrop.any():
        return None
    solid = np.zeros(len(scene.vertices), bool)
    solid[scene.triangles[~backdrop[scene.triangle_material]]] = True
    return solid


def extents_of(vertices: Floats, solid: Mask | None) -> Floats:
    """Of each block of `vertices` (vertex, 3), the largest size (block, 3) of each coordinate of those that are `solid`
    (vertex,), 0 without any.
    """
    sizes = np.abs(vertices) if solid is None else np.abs(vertices) * solid[:, None]
    return np.maximum.reduceat(sizes, np.arange(0, len(sizes), BLOCK), axis=0)


def renewed(extents: Floats, vertices: Floats, solid: Mask | None, begin: int, end: int) -> Floats:
    """`extents` of other `vertices`, which differ from `begin` to `end`."""
    first, last = begin // BLOCK, -(-end // BLOCK)
    own = slice(first * BLOCK, last * BLOCK)
    found = extents.copy()
    if end > begin:
        found[first:last] = extents_of(vertices[own], None if solid is None else solid[own])
    return found

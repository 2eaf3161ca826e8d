"""Which triangles have an area that single precision can tell from none."""

import numpy as np

from gpu.scene.geometry.boxes import lengths
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.types import Doubles, Integers, Mask

# Twice a triangle's area in unit space, relative to its longest edge squared and absolute: below, float32 sees a line.
_RELATIVE_AREA, _ABSOLUTE_AREA = 1e-12, 1e-24


def sound(unit: Doubles, triangles: Integers) -> Mask:
    """Which triangles, (triangle, 3) indices of unit-space positions, are more than a point or a line."""
    a, b, c = (unit.take(triangles[:, corner], axis=0) for corner in range(3))
    with np.errstate(over="ignore", invalid="ignore"):  # what is too far away for numbers is not sound
        longest = np.maximum.reduce([np.einsum("tc,tc->t", edge, edge) for edge in (b - a, c - b, a - c)])
        area = lengths(area_vectors(unit, triangles))
        return np.asarray(area > np.maximum(_RELATIVE_AREA * longest, _ABSOLUTE_AREA))

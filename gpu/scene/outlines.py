"""What readers of polygons have in common: positions that may be broken where nothing uses them, faces to triangles."""

from collections.abc import Callable

import numpy as np

from gpu.errors import SceneError
from gpu.scene.polygons import Triangulation, triangulate
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles, Integers
from gpu.scene.validate import FARTHEST


def usable_positions(
    source: str,
    positions: Doubles,
    corners: Integers,
    remarks: Remarks,
    place: Callable[[int], str] = "vertex {}".format,
) -> Doubles:
    """`positions` (vertex, 3) with zeros where no corner uses one that is not finite or too far away, which is said.

    corners (corner,): which are used; place: what to call a vertex by its index.
    Raises SceneError naming the first broken one that is used.
    """
    broken = np.any(~(np.abs(positions) <= FARTHEST), axis=1)  # NaN, too
    if not broken.any():
        return positions
    used = corners[broken[corners]]
    if len(used):
        row = int(used.min())
        raise SceneError(source, place(row), f"is not finite or too far away: {positions[row].tolist()}; repair it")
    remarks.add_count("vertices that no face uses are not finite or too far away and were left out", int(broken.sum()))
    return np.where(broken[:, None], 0.0, positions)


def covered(positions: Doubles, corners: Integers, counts: Integers, remarks: Remarks) -> Triangulation:
    """`triangulate`, with sentences on polygons that have no sound shape."""
    found = triangulate(positions, corners, counts)
    remarks.add_count("faces with fewer than 3 corners were left out", found.too_small)
    remarks.add_count("polygons that cross themselves: their shape is a guess", found.crossing)
    return found

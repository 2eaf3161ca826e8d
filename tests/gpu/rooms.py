"""Rooms as arrays, for tests of what is guessed of files."""

from itertools import product

import numpy as np

from gpu.scene.types import Doubles, Integers

# Of a box's corners in the order of `product`, the faces seen from inside.
_FACES = ("0132", "4675", "0451", "2376", "0264", "1573")


def room(width: float, depth: float, height: float, up: int = 1) -> tuple[Doubles, Integers]:
    """Positions (8, 3) and triangles (12, 3) of a box with its corner at zero, seen from inside; height along `up`."""
    sides = [width, depth]
    sides.insert(up, height)
    corners = np.array(list(product(*((0.0, side) for side in sides))))
    quads = np.array([[int(corner) for corner in face] for face in _FACES])
    return corners, np.concatenate([quads[:, [0, 2, 1]], quads[:, [0, 3, 2]]])

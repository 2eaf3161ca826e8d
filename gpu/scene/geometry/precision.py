"""Where single precision falls below what is seen of a scene: in its file, and on the device."""

import numpy as np

from gpu.scene.geometry.boxes import largest, middles
from gpu.scene.geometry.bulk import Bulk
from gpu.scene.lengths import length_text
from gpu.scene.types import Doubles, Floats, Integers

# Parts of the scene's extent that positions in a file may be rounded to.
FILE_STEP = 1e-4
# Rays begin so far off their surfaces, as a share of the distance from the middle of unit space, and of no less than
# this (gpu.device_scene.rays); and so large a part of what most triangles make up is seen.
RAY_OFFSET, NEAREST, SEEN = 32.0 * 2.0**-23, 0.0625, 0.01


def file_precision(positions: Doubles, bulk: Bulk, metres_per_unit: float) -> list[str]:
    """A sentence if positions (vertex, 3) of the bulk were rounded to single precision too far from the origin."""
    largest = float(np.abs([bulk.low, bulk.high]).max())
    step = float(np.spacing(np.float32(largest))) if largest < float(np.finfo(np.float32).max) else 0.0
    if step <= FILE_STEP * float((bulk.high - bulk.low).max()) or (positions != positions.astype(np.float32)).any():
        return []
    rounded = length_text(step * metres_per_unit)
    return [f"positions in the file are rounded to {rounded}: write them about an origin that is near, or as doubles"]


def device_precision(vertices: Floats, triangles: Integers, extent: float) -> list[str]:
    """A sentence if half of the triangles, (triangle, 3) indices of unit-space vertices, are small beside all of them.

    extent: of unit space in the world [m].
    """
    centre = np.array([np.median(column) for column in middles(vertices.astype(np.float64), triangles).T])
    radius = float(np.median(largest(largest(vertices - centre)[triangles])))
    offset = RAY_OFFSET * max(float(np.abs(centre).max()), NEAREST)
    if offset <= SEEN * radius:
        return []
    return [
        f"the scene is {length_text(extent)} large, so that light leaks up to {length_text(offset * extent)} where "
        "surfaces touch; leave out what is far away"
    ]

"""What readers of polygons have in common: positions that may be broken where nothing uses them, faces to triangles."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gpu.errors import SceneError
from gpu.scene.geometry.polygons import TOO_LARGE, Triangulation, triangulate
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers
from gpu.scene.validate import FARTHEST

_OUT_OF_RANGE = 2.0**53


def whole(values: Doubles) -> Integers:
    """`values` that a file has as indices; what is no whole number, or too large for one, becomes one out of range."""
    sound = (values == np.floor(values)) & (np.abs(values) < _OUT_OF_RANGE)
    return np.where(sound, values, _OUT_OF_RANGE).astype(np.int64)


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
    remarks.add_count(TOO_LARGE, found.too_large)
    return found


@dataclass(frozen=True, eq=False)
class FaceMesh:
    """Polygons as files of bare meshes have them.

    positions (vertex, 3); corners (corner,): the faces' vertices one after another; counts (face,): how many corners
    each has; normals (vertex, 3), colors (vertex, 4) and face_colors (face, 4), linear, where there are any.
    """

    positions: Doubles
    corners: Integers
    counts: Integers
    normals: Doubles | None = None
    colors: Doubles | None = None
    face_colors: Doubles | None = None


def face_part(source: str, mesh: FaceMesh, remarks: Remarks) -> MeshPart:
    """The triangles of `mesh`; with colours of faces each triangle has vertices of its own.

    Raises SceneError naming the first face with a corner that does not exist or is not finite.
    """
    wrong = (mesh.corners < 0) | (mesh.corners >= len(mesh.positions))
    if wrong.any():
        face = int(np.searchsorted(np.cumsum(mesh.counts), np.argmax(wrong), "right"))
        start = int(mesh.counts[:face].sum())
        indices = mesh.corners[start : start + min(int(mesh.counts[face]), 12)].tolist()
        raise SceneError(
            source, f"face {face}", f"index out of range: {indices}, there are {len(mesh.positions)} vertices"
        )
    positions = usable_positions(source, mesh.positions, mesh.corners, remarks)
    cut = covered(positions, mesh.corners, mesh.counts, remarks)
    normals, colors, triangles = mesh.normals, mesh.colors, mesh.corners[cut.triangles]
    if normals is not None:
        broken = np.any(~np.isfinite(normals), axis=1)
        remarks.add_count("normals that are not finite: the geometric ones were taken", int(broken.sum()))
    if mesh.face_colors is not None and colors is None:
        vertices = triangles.reshape(-1)
        positions, triangles = positions[vertices], np.arange(len(vertices)).reshape(-1, 3)
        normals = None if normals is None else normals[vertices]
        colors = np.repeat(mesh.face_colors[cut.polygons], 3, axis=0)
    elif mesh.face_colors is not None:
        remarks.add("colours of faces were ignored: the vertices have some")
    return MeshPart(positions, triangles, normals, colors=colors, name="faces")

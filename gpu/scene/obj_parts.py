"""Faces of OBJ files as mesh parts: polygons cut, corners made vertices, normals of smoothing groups."""

from dataclasses import replace

import numpy as np

from gpu.errors import SceneError
from gpu.scene.assemble import MeshPart
from gpu.scene.mesh_colors import linear_colors
from gpu.scene.normals import smooth_normals
from gpu.scene.obj_statements import MOST_OBJECTS, ObjFile, row_line
from gpu.scene.outlines import covered, usable_positions
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles, Integers


class ObjParts:
    """The mesh parts of an OBJ file. colors: (v, 4) linear, or None."""

    def __init__(self, file: ObjFile, text: str, remarks: Remarks) -> None:
        """Raises SceneError naming the line of a face whose corner does not exist, or of a v that is not finite."""
        self._remarks = remarks
        self._corners = np.array(file.corners, np.int64).reshape(-1, 3)
        _check_corners(file, self._corners)
        self._positions = usable_positions(
            file.source,
            file.table("v"),
            self._corners[:, 0],
            remarks,
            lambda row: f"line {row_line(text, 'v', row)}: v",
        )
        self._normals = self._with_none(
            file.table("vn"), 2, "normals that are not finite: the geometric ones were taken", np.nan
        )
        uvs = self._with_none(file.table("vt"), 1, "texture coordinates that are not finite: 0 0 was taken", 0.0)
        # v = 0 is the bottom of an OBJ texture, the top of a glTF one.
        self._uvs = uvs * (1.0, -1.0) + (0.0, 1.0) if file.count("vt") else None
        self.colors = linear_colors(np.array(file.colors).reshape(-1, 3), remarks) if file.colors else None
        self._faces = file.faces
        self._objects = _object_names(file, remarks)

    def parts(self, materials: dict[str, int]) -> list[MeshPart]:
        """A part or two for each material and smoothing group; materials: the number of each name."""
        found = []
        for (material, smoothing), (corners, counts, owners) in self._faces.items():
            ids = np.array(corners, np.int64)
            cut = covered(self._positions, self._corners[ids, 0], np.array(counts, np.int64), self._remarks)
            triangles = ids[cut.triangles]
            starts = np.cumsum([0, *counts[:-1]])
            shaded = (np.minimum.reduceat(self._corners[ids, 2], starts) >= 0)[cut.polygons]
            own = np.array(owners, np.int64)[cut.polygons]
            for some, smooth in ((shaded, True), (~shaded, smoothing > 0)):
                if some.any():
                    part = self._part(triangles[some], own[some], smooth)
                    found.append(replace(part, material=materials[material], name=material or "faces"))
        return found

    def _with_none(self, rows: Doubles, column: int, sentence: str, instead: float) -> Doubles:
        """`rows` with `instead` of what is not finite, and a last one, that of corners without any."""
        broken = np.any(~np.isfinite(rows), axis=1)
        used = np.zeros(len(rows), bool)
        used[self._corners[self._corners[:, column] >= 0, column]] = True
        self._remarks.add_count(sentence, int((broken & used).sum()))
        return np.concatenate([np.where(broken[:, None], instead, rows), np.full((1, rows.shape[1]), instead)])

    def _part(self, triangles: Integers, owners: Integers, smooth: bool) -> MeshPart:
        """A part of `triangles` (triangle, 3) of corners, which are of the objects `owners` (triangle,); without
        `smooth` its normals are those of its triangles.
        """
        if not self._objects:
            owners = np.zeros_like(owners)
        ids, own = np.unique(owners, return_inverse=True)
        used, compact = np.unique(own[:, None] * len(self._corners) + triangles, return_inverse=True)
        vertex_object, corners = np.divmod(used, len(self._corners))
        v, vt, vn = self._corners[corners].T
        normals = None
        if smooth:
            normals = self._normals[vn]
            if (vn < 0).any():
                summed = smooth_normals(self._positions, self._corners[triangles, 0])
                normals = np.where((vn < 0)[:, None], summed[v], normals)
        return MeshPart(
            positions=self._positions[v],
            triangles=compact.reshape(-1, 3),
            normals=normals,
            uvs=() if self._uvs is None else (self._uvs[vt],),
            colors=None if self.colors is None else self.colors[v],
            objects=tuple(self._objects[number] for number in ids) if self._objects else (),
            vertex_object=vertex_object,
        )


def _object_names(file: ObjFile, remarks: Remarks) -> list[str]:
    """What the objects of `file` are called; none where it has no names, or too many."""
    if len(file.objects) > MOST_OBJECTS:
        remarks.add(f"has more than {MOST_OBJECTS:,} names of objects or groups: its materials are its objects")
        return []
    return [name or "default" for name in file.objects] if any(file.objects) else []


def _check_corners(file: ObjFile, corners: Integers) -> None:
    """Raise SceneError for the first corner whose v, vt or vn is not in the file."""
    missing = corners >= [file.count(key) for key in file.rows]
    if missing.any():
        corner, column = np.argwhere(missing)[0]
        key = list(file.rows)[column]
        problem = f"{key} index '{corners[corner, column] + 1}' does not exist, there are {file.count(key)}"
        raise SceneError(file.source, f"line {file.lines[corner]}", problem)

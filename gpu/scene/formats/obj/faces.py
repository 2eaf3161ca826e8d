"""Faces of OBJ files as mesh parts: polygons cut, corners made vertices, normals of smoothing groups."""

from array import array
from dataclasses import replace

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.mesh_colors import linear_colors
from gpu.scene.formats.obj.statements import MOST_OBJECTS, WIDTHS, ObjFile, row_line
from gpu.scene.formats.outlines import covered, usable_positions
from gpu.scene.geometry.normals import smooth_normals
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers, Ints

_MOST_KEY = 1 << 62  # of rows that are told apart by one number


class ObjParts:
    """The mesh parts of an OBJ file. colors: (v, 4) linear, or None."""

    def __init__(self, file: ObjFile, text: str, remarks: Remarks) -> None:
        """Raises SceneError naming the line of a face whose corner does not exist, or of a v that is not finite."""
        self._remarks, self._faces = remarks, file.faces
        _check_corners(file)
        corners = [_corners(faces.corners) for faces in file.faces.values()]
        used = np.concatenate(corners) if corners else np.empty((0, 3), np.int32)
        self._positions = usable_positions(
            file.source,
            file.table("v"),
            used[:, 0],
            remarks,
            lambda row: f"line {row_line(text, 'v', row)}: v",
        )
        self._normals = self._with_none(
            file.table("vn"), used[:, 2], "normals that are not finite: the geometric ones were taken", np.nan
        )
        uvs = self._with_none(
            file.table("vt"), used[:, 1], "texture coordinates that are not finite: 0 0 was taken", 0.0
        )
        # v = 0 is the bottom of an OBJ texture, the top of a glTF one.
        self._uvs = uvs * (1.0, -1.0) + (0.0, 1.0) if file.count("vt") else None
        self.colors = linear_colors(np.array(file.colors).reshape(-1, 3), remarks) if file.colors else None
        self._objects = _object_names(file, remarks)

    def parts(self, materials: dict[str, int]) -> list[MeshPart]:
        """A part or two for each material and smoothing group; materials: the number of each name."""
        found = []
        for (material, smoothing), faces in self._faces.items():
            corners, counts = _corners(faces.corners), np.array(faces.counts, np.int64)
            cut = covered(self._positions, corners[:, 0], counts, self._remarks)
            shaded = (np.minimum.reduceat(corners[:, 2], np.cumsum(counts) - counts) >= 0)[cut.polygons]
            owners = np.array(faces.owners)[cut.polygons]
            for some, smooth in ((shaded, True), (~shaded, smoothing > 0)):
                if some.any():
                    part = self._part(corners[cut.triangles[some]], owners[some], smooth)
                    found.append(replace(part, material=materials[material], name=material or "faces"))
        return found

    def _with_none(self, rows: Doubles, used: Ints, sentence: str, instead: float) -> Doubles:
        """`rows` with `instead` of what is not finite, and a last one, that of corners without any.

        used: which of them corners have, −1 for none.
        """
        broken = np.append(np.any(~np.isfinite(rows), axis=1), False)
        if broken.any():
            there = np.zeros(len(broken), bool)
            there[used] = True
            self._remarks.add_count(sentence, int((broken & there).sum()))
        rows = np.concatenate([rows, np.full((1, rows.shape[1]), instead)])
        return np.where(broken[:, None], instead, rows)

    def _part(self, corners: Ints, owners: Ints, smooth: bool) -> MeshPart:
        """A part of triangles with these corners (triangle, 3, 3), of the objects `owners` (triangle,); without
        `smooth` its normals are those of its triangles.
        """
        names, own = np.unique(owners if self._objects else np.zeros_like(owners), return_inverse=True)
        rows = np.concatenate([np.repeat(own, 3)[:, None], corners.reshape(-1, 3)], axis=1)
        first, vertices = _distinct(rows)
        vertex_object, v, vt, vn = rows[first].T
        normals = None
        if smooth:
            normals = self._normals[vn]
            if (vn < 0).any():
                summed = smooth_normals(self._positions, corners[:, :, 0])
                normals = np.where((vn < 0)[:, None], summed[v], normals)
        return MeshPart(
            positions=self._positions[v],
            triangles=vertices.reshape(-1, 3),
            normals=normals,
            uvs=() if self._uvs is None else (self._uvs[vt],),
            colors=None if self.colors is None else self.colors[v],
            objects=tuple(self._objects[number] for number in names) if self._objects else (),
            vertex_object=vertex_object,
        )


def _corners(listed: "array[int]") -> Ints:
    """v, vt and vn of corners (corner, 3), counted from 0, −1 for none."""
    return np.frombuffer(listed, np.int32).reshape(-1, 3)


def _distinct(rows: Integers) -> tuple[Integers, Integers]:
    """Of `rows` (row, column), each −1 or more, which are the first of their kind, and of which kind each is."""
    key, range_ = np.zeros(len(rows), np.int64), 1
    for column in rows.T:
        size = int(column.max()) + 2
        if range_ * size > _MOST_KEY:
            kinds, key = np.unique(key, return_inverse=True)
            range_ = len(kinds)
        key, range_ = key * size + column + 1, range_ * size
    _, first, kind = np.unique(key, return_index=True, return_inverse=True)
    return first, kind


def _object_names(file: ObjFile, remarks: Remarks) -> list[str]:
    """What the objects of `file` are called; none where it has no names, or too many."""
    if len(file.objects) > MOST_OBJECTS:
        remarks.add(f"has more than {MOST_OBJECTS:,} names of objects or groups: its materials are its objects")
        return []
    return [name or "default" for name in file.objects] if any(file.objects) else []


def _check_corners(file: ObjFile) -> None:
    """Raise SceneError for the first corner whose v, vt or vn is not in the file."""
    there, problems = [file.count(key) for key in WIDTHS], dict[int, str]()
    for faces in file.faces.values():
        corners = _corners(faces.corners)
        missing = corners >= there
        if missing.any():
            corner, column = np.argwhere(missing)[0]
            line = faces.lines[int(np.searchsorted(np.cumsum(faces.counts), corner, "right"))]
            key = list(WIDTHS)[column]
            problems[line] = f"{key} index '{corners[corner, column] + 1}' does not exist, there are {there[column]}"
    if problems:
        line = min(problems)
        raise SceneError(file.source, f"line {line}", problems[line])

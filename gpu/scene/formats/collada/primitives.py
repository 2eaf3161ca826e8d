"""Polygons of COLLADA geometries: corners with what each has, from sources that they share."""

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.collada.document import Document
from gpu.scene.formats.mesh_colors import linear_colors
from gpu.scene.formats.outlines import whole
from gpu.scene.types import Doubles, Integers

_SURFACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")


@dataclass(frozen=True, eq=False)
class Corners:
    """Polygons of one material symbol. positions (vertex, 3); vertices (corner,): of the polygons, one after another.

    counts (polygon,): their corners; normals (corner, 3), colors (corner, 4) linear, uvs (corner, 2) by their set.
    """

    place: str
    material: str
    positions: Doubles
    vertices: Integers
    counts: Integers
    normals: Doubles | None
    colors: Doubles | None
    uvs: dict[int, Doubles]


class Primitives:
    """Reads the polygons of geometries."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._sources: dict[str | None, Doubles | None] = {}

    def of(self, geometry: Element) -> Iterator[Corners]:
        """The polygons of `geometry`. Raises SceneError where it is broken."""
        place = f"geometry {geometry.get('name') or geometry.get('id') or ''}".strip()
        mesh = geometry.find("mesh")
        for element in () if mesh is None else mesh:
            if element.tag in _SURFACES:
                yield from self._corners(element, place)

    def _corners(self, element: Element, place: str) -> Iterator[Corners]:
        inputs = list(self._inputs(element, place))
        positions = next((self._source(source) for _, kind, source, _ in inputs if kind == "POSITION"), None)
        if positions is None or positions.shape[1] < 3:
            raise SceneError(str(self._document.path), place, f"its {element.tag} have no positions of three numbers")
        rows, counts = self._polygons(element, 1 + max(offset for offset, *_ in inputs), place)
        if not len(rows):
            return
        found: dict[str, Doubles] = {}
        uvs: dict[int, Doubles] = {}
        vertices = np.empty(0, np.int64)
        for offset, kind, source, uv_set in inputs:
            if kind == "POSITION":
                vertices = rows[:, offset]
            elif kind in ("NORMAL", "COLOR", "TEXCOORD"):
                values = self._values(source, rows[:, offset], 2 if kind == "TEXCOORD" else 3, f"{place}: {kind}")
                if values is not None and kind == "TEXCOORD":
                    uvs.setdefault(uv_set, values[:, :2])
                elif values is not None:
                    found.setdefault(kind, values)
        colors = found.get("COLOR")
        yield Corners(
            place,
            element.get("material", ""),
            positions[:, :3],
            vertices,
            counts,
            found["NORMAL"][:, :3] if "NORMAL" in found else None,
            None if colors is None else linear_colors(colors[:, :4], self._document.remarks, 1.0),
            uvs,
        )

    def _inputs(self, element: Element, place: str) -> Iterator[tuple[int, str, str | None, int]]:
        """Offset, meaning, source and set of each input; those of <vertices> with the offset of what names them."""
        for found in element.findall("input"):
            try:
                offset, uv_set = int(found.get("offset", "0")), int(found.get("set", "0"))
            except ValueError as error:
                raise SceneError(str(self._document.path), place, f"an input's offset or set: {error}") from error
            if not 0 <= offset < 64:
                raise SceneError(str(self._document.path), place, f"an input's offset is {offset}")
            if found.get("semantic") == "VERTEX":
                vertices = self._document.find(found.get("source"), "vertices")
                for inner in () if vertices is None else vertices.findall("input"):
                    yield offset, inner.get("semantic", ""), inner.get("source"), uv_set
            else:
                yield offset, found.get("semantic", ""), found.get("source"), uv_set

    def _polygons(self, element: Element, stride: int, place: str) -> tuple[Integers, Integers]:
        """Indices (corner, stride) and how many corners each polygon has."""
        lists = [self._rows(each, stride, f"{place}: {element.tag}") for each in element.findall("p")]
        if element.tag == "polygons":
            for holed in element.findall("ph"):
                self._document.remarks.add("holes of polygons are shown filled", place)
                lists.append(self._rows(holed.find("p"), stride, place))
            return _joined(lists, stride), np.array([len(rows) for rows in lists], np.int64)
        if element.tag in ("tristrips", "trifans"):
            lists = [rows[_pieces(element.tag, len(rows))] for rows in lists if len(rows) >= 3]
        rows = _joined(lists, stride)
        if element.tag != "polylist":
            if len(rows) % 3:
                raise SceneError(str(self._document.path), place, f"{len(rows)} corners of triangles, not three each")
            return rows, np.full(len(rows) // 3, 3, np.int64)
        counts = whole(self._document.numbers(element.find("vcount"), f"{place}: vcount"))
        if (counts < 0).any() or (counts > len(rows)).any() or counts.sum() != len(rows):
            raise SceneError(str(self._document.path), place, f"vcount is not of its {len(rows)} corners")
        return rows, counts

    def _rows(self, element: Element | None, stride: int, place: str) -> Integers:
        values = self._document.numbers(element, place)
        if len(values) % stride:
            raise SceneError(str(self._document.path), place, f"{len(values)} indices, not {stride} for each corner")
        return whole(values).reshape(-1, stride)

    def _values(self, source: str | None, rows: Integers, width: int, place: str) -> Doubles | None:
        """The rows of a source that `rows` (corner,) name; None, and said, where one does not exist."""
        values, remarks = self._source(source), self._document.remarks
        if values is None or values.shape[1] < width:
            remarks.add("a source without enough numbers was left out", place)
            return None
        if rows.min() < 0 or rows.max() >= len(values):
            remarks.add("indices out of range: what they name was left out", place)
            return None
        found = values[rows]
        broken = ~np.isfinite(found)
        if width == 2 and broken.any():
            remarks.add("texture coordinates that are not finite: 0 was taken", place)
            found = np.where(broken, 0.0, found)
        return found

    def _source(self, url: str | None) -> Doubles | None:
        """The numbers (row, column) of a source, each read once; columns without a name are none."""
        if url not in self._sources:
            self._sources[url] = self._read(url)
        return self._sources[url]

    def _read(self, url: str | None) -> Doubles | None:
        source = self._document.find(url, "source")
        if source is None:
            return None
        place = f"source {url or ''}"
        accessor = source.find("technique_common/accessor")
        array = source.find("float_array")
        if array is None and accessor is not None:
            array = self._document.find(accessor.get("source"), "float_array")
        values = self._document.numbers(array, place)
        params = [] if accessor is None else accessor.findall("param")
        if accessor is None or not params:
            raise SceneError(str(self._document.path), place, "has no accessor that says what its numbers are")
        try:
            offset, stride = int(accessor.get("offset", "0")), int(accessor.get("stride", len(params)))
            count = int(accessor.get("count", max(len(values) - offset, 0) // max(stride, 1)))
        except ValueError as error:
            raise SceneError(str(self._document.path), place, f"its accessor: {error}") from error
        if min(offset, count) < 0 or stride < 1 or offset + count * stride > len(values):
            problem = f"{count} rows of {stride} numbers from {offset} on, but there are {len(values)} numbers"
            raise SceneError(str(self._document.path), place, problem)
        named = [number for number, param in enumerate(params) if param.get("name")] or list(range(len(params)))
        table = values[offset : offset + count * stride].reshape(count, stride)
        return table[:, [column for column in named if column < stride]]


def _joined(lists: list[Integers], stride: int) -> Integers:
    return np.concatenate([np.empty((0, stride), np.int64), *lists])


def _pieces(kind: str, corners: int) -> Integers:
    """The corners (3 × triangle,) of the triangles of a strip or fan."""
    first = np.arange(corners - 2)
    if kind == "trifans":
        return np.stack([np.zeros_like(first), first + 1, first + 2], axis=1).reshape(-1)
    odd = first % 2
    return np.stack([first, first + 1 + odd, first + 2 - odd], axis=1).reshape(-1)

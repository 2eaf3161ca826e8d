from pathlib import Path

import numpy as np
import pytest
from dae_file import QUAD, UVS, dae, geometry, source

from gpu.errors import SceneError
from gpu.scene.formats.collada.document import Document, open_document
from gpu.scene.formats.collada.primitives import Corners, Primitives
from gpu.scene.limits import DEFAULT_LIMITS

UV_INPUT = '<input semantic="TEXCOORD" source="#u" offset="1" set="2"/>'
UV_SURFACE = "<triangles><p>0 3 1 2 2 1</p></triangles>"


def read(folder: Path, mesh: str) -> tuple[list[Corners], Document]:
    (folder / "a.dae").write_bytes(dae(geometries=mesh))
    document = open_document(folder / "a.dae", DEFAULT_LIMITS)
    found = document.root.find("library_geometries/geometry")
    assert found is not None
    return list(Primitives(document).of(found)), document


@pytest.mark.parametrize(
    ("surface", "vertices", "counts"),
    [
        ("<triangles><p>0 1 2 0 2 3</p></triangles>", [0, 1, 2, 0, 2, 3], [3, 3]),
        ("<polylist><vcount>3 4</vcount><p>0 1 2 0 1 2 3</p></polylist>", [0, 1, 2, 0, 1, 2, 3], [3, 4]),
        ("<polygons><p>0 1 2 3</p><p>0 1 2</p></polygons>", [0, 1, 2, 3, 0, 1, 2], [4, 3]),
        ("<polygons><ph><p>0 1 2 3</p><h>1 2 3</h></ph></polygons>", [0, 1, 2, 3], [4]),
        ("<tristrips><p>0 1 3 2</p><p>0 1</p></tristrips>", [0, 1, 3, 1, 2, 3], [3, 3]),
        ("<trifans><p>0 1 2 3</p></trifans>", [0, 1, 2, 0, 2, 3], [3, 3]),
    ],
)
def test_polygons(tmp_path: Path, surface: str, vertices: list[int], counts: list[int]) -> None:
    (corners,), document = read(tmp_path, geometry(surface=surface))
    assert (corners.vertices.tolist(), corners.counts.tolist(), corners.material) == (vertices, counts, "m")
    assert any("holes" in said for said in document.remarks.sentences()) == ("<ph>" in surface)


def test_corners_have_their_own_indices_and_columns_without_a_name_are_none(tmp_path: Path) -> None:
    normals = source("n", "0 0 1 9  0 1 0 9", "XYZ_").replace('"_"', '""')
    inputs = UV_INPUT + '<input semantic="NORMAL" source="#n" offset="2"/>'
    surface = "<triangles><p>0 3 0 1 2 1 2 1 1</p></triangles>"
    (corners,), _ = read(tmp_path, geometry(surface=surface, sources=source("u", UVS, "ST") + normals, inputs=inputs))
    assert corners.uvs[2].tolist() == [[0, 1], [1, 1], [1, 0]]
    assert corners.normals is not None
    assert corners.normals.tolist() == [[0, 0, 1], [0, 1, 0], [0, 1, 0]]
    np.testing.assert_array_equal(corners.positions[corners.vertices], [[0, 0, 0], [100, 0, 0], [100, 200, 0]])


@pytest.mark.parametrize(
    ("uvs", "says"),
    [("0 0  1 0", "indices out of range"), ("0 0  1 0  NaN 1  0 1", "not finite: 0 was taken")],
)
def test_broken_coordinates_are_said(tmp_path: Path, uvs: str, says: str) -> None:
    mesh = geometry(surface=UV_SURFACE, sources=source("u", uvs, "ST"), inputs=UV_INPUT)
    _, document = read(tmp_path, mesh)
    assert any(says in said for said in document.remarks.sentences())


@pytest.mark.parametrize(
    ("mesh", "says"),
    [
        (geometry(surface="<triangles><p>0 1</p></triangles>"), "2 corners of triangles"),
        (geometry(surface="<triangles><p>0 1 a</p></triangles>"), "needs numbers"),
        (geometry(surface="<polylist><vcount>5</vcount><p>0 1 2 3</p></polylist>"), "vcount is not of its 4"),
        (geometry(surface=UV_SURFACE.replace(" 1</p>", "</p>"), sources=source("u", UVS, "ST"), inputs=UV_INPUT),
         "5 indices, not 2 for each corner"),
        (geometry().replace('source="#g-p"', 'source="#x"'), "no positions"),
        (geometry().replace('offset="0"', 'offset="a"'), "an input's offset"),
        (geometry().replace('offset="0"', 'offset="99999999"'), "an input's offset is"),
        (geometry().replace('count="4"', 'count="5"'), "5 rows of 3 numbers from 0 on, but there are 12"),
        (geometry().replace('stride="3"', 'stride="0"'), "rows of 0 numbers"),
        (geometry(points=QUAD + " 1").replace("<param", "<parm"), "no accessor"),
    ],
)  # fmt: skip
def test_what_is_broken_is_refused(tmp_path: Path, mesh: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        read(tmp_path, mesh)

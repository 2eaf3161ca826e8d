import struct
from pathlib import Path

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.meshes import load_mesh
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.types import Scene

OFF = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
STL = """solid a
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet
endsolid a
"""
PLY = """ply\nformat ascii 1.0\nelement vertex 4
property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz
property uchar red\nproperty uchar green\nproperty uchar blue
element face 2\nproperty list uchar int vertex_indices\nend_header
0 0 0 0 0 2 255 188 0
1 0 0 0 0 2 255 188 0
1 1 0 0 0 2 255 188 0
0 1 0 0 0 2 255 188 0
3 0 1 2
3 0 2 3
"""
BINARY_STL = bytes(80) + struct.pack("<I", 1) + struct.pack("<12fH", *(0, 0, 1), *(0, 0, 0), *(1, 0, 0), *(0, 1, 0), 0)


def load(folder: Path, suffix: str, content: str | bytes) -> Scene:
    path = folder / f"scene.{suffix}"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return load_mesh(path, DEFAULT_LIMITS)


@pytest.mark.parametrize(("suffix", "content", "triangles"), [
    ("off", OFF, 2), ("stl", STL, 2), ("ply", PLY, 2), ("stl", BINARY_STL, 1),
    ("off", OFF.replace("OFF\n", "OFF\n# a comment\n\n"), 2), ("off", OFF.encode("utf-16"), 2),
    ("ply", PLY.encode("utf-8-sig"), 2), ("stl", STL.encode("utf-16"), 2), ("PLY", PLY.replace("\n", "\r\n"), 2),
])  # fmt: skip
def test_each_format(tmp_path: Path, suffix: str, content: str | bytes, triangles: int) -> None:
    scene = load(tmp_path, suffix, content)
    assert len(scene.triangles) == triangles
    assert np.allclose(scene.normals, (0, 0, 1))
    assert scene.report.ignored == ()
    colored = suffix.lower() == "ply"
    assert scene.materials[0].base_color == ((1, 1, 1, 1) if colored else (0.8, 0.8, 0.8, 1.0))
    assert (scene.colors is not None) == colored


@pytest.mark.parametrize("normal", ["1 0 0", "nan 0 0"])
def test_the_normals_of_a_ply_file_are_used_where_they_are_sound(tmp_path: Path, normal: str) -> None:
    scene = load(tmp_path, "ply", PLY.replace("0 0 2", normal))
    assert len(scene.vertices) == 4
    assert np.allclose(scene.normals, (1, 0, 0) if normal == "1 0 0" else (0, 0, 1))


U = ["-2 2 0", "2 2 0", "2 -2 0", "1 -2 0", "1 1 0", "-1 1 0", "-1 -2 0", "-2 -2 0"]
U_FACE = "8 0 1 2 3 4 5 6 7\n"


@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        ("off", "OFF\n8 1 0\n" + "\n".join(U) + "\n" + U_FACE),
        (
            "ply",
            "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n" + "\n".join(U) + "\n" + U_FACE,
        ),
        (
            "stl",
            "solid u\nfacet normal 0 0 -1\nouter loop\nvertex " + "\nvertex ".join(U) + "\nendloop\nendfacet\nendsolid",
        ),
    ],
)
def test_concave_polygons_keep_their_shape(tmp_path: Path, suffix: str, content: str) -> None:
    scene = load(tmp_path, suffix, content)
    areas = np.linalg.norm(area_vectors(scene.vertices.astype(np.float64), scene.triangles), axis=1) / 2.0
    assert areas.sum() / scene.placement.scale**2 == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("suffix", "content", "says"),
    [
        ("off", "", "OFF header"),
        ("off", OFF.replace("3 0 2 3\n", ""), "4 vertices and 2 faces, but only 5 lines follow"),
        ("off", OFF.replace("4 2 0", "x"), "OFF header"),
        ("off", OFF.replace("0 2 3", "0 2 4"), "face 1: index out of range: [0, 2, 4], there are 4 vertices"),
        ("off", OFF.replace("1 1 0", "1 nan 0"), "vertex 2: is not finite"),
        ("stl", "solid", "not an STL file"),
        ("stl", STL[:140], "the file is cut off"),
        ("stl", BINARY_STL[:-9], "1 facets, but only 0 follow; the file is cut off"),
        ("ply", "", "not a PLY file"),
        ("ply", PLY.replace("0 2 3", "0 2 9"), "face 1: index out of range: [0, 2, 9], there are 4 vertices"),
        ("ply", PLY.replace("1 1 0 0", "inf 1 0 0"), "vertex 2: is not finite"),
        ("ply", PLY.replace("3 0 1 2\n3 0 2 3\n", ""), "element face: the file ends before its 2 rows do"),
        (
            "ply",
            PLY.replace("vertex 4", "vertex 99999999999"),
            "element vertex: the file ends before its 99,999,999,999",
        ),
        ("ply", PLY.replace("vertex 4", "vertex -4"), "header line 3"),
    ],
)
def test_what_is_broken_is_refused(tmp_path: Path, suffix: str, content: str | bytes, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, suffix, content)
    assert says in str(caught.value)
    assert f"scene.{suffix}" in str(caught.value)

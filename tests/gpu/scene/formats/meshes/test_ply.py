"""PLY files: colours, normals and strips that are used, and the sum of what is not."""

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.meshes.ply import read_ply
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart

SQUARE = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
FACES = ["3 0 1 2", "3 0 2 3"]
RED = (0.7913, 0.0130, 0.0070)  # of 230 30 20


def ply(vertex: str = "", face: str = "", after: tuple[str, str] = ("", ""), more: str = "", body: str = "") -> bytes:
    """A square of two triangles. vertex, face: further properties; after: what their rows have there."""
    xyz = "property float x\nproperty float y\nproperty float z\n"
    rows = [f"{row} {after[0]}" for row in SQUARE] + [f"{row} {after[1]}" for row in FACES]
    return (
        f"ply\nformat ascii 1.0\nelement vertex 4\n{xyz}{vertex}element face 2\n"
        f"property list uchar int vertex_indices\n{face}{more}end_header\n" + "\n".join(rows) + f"\n{body}"
    ).encode()


def read(content: bytes) -> tuple[MeshPart, tuple[str, ...]]:
    remarks = Remarks()
    return read_ply("a.ply", content, remarks), remarks.sentences()


def channels(kind: str, names: str) -> str:
    return "".join(f"property {kind} {name}\n" for name in names.split())


@pytest.mark.parametrize(
    ("kind", "names", "values"),
    [
        ("uchar", "red green blue", "230 30 20"),
        ("uint8", "diffuse_red diffuse_green diffuse_blue", "230 30 20"),
        ("uchar", "r g b a", "230 30 20 255"),
        ("float", "red green blue alpha", "0.902 0.1176 0.0784 1"),
        ("double", "red green blue", "230 30 20"),
        ("ushort", "red green blue", "59110 7710 5140"),
    ],
)
def test_colours_of_vertices_or_faces(kind: str, names: str, values: str) -> None:
    by_vertex = read(ply(vertex=channels(kind, names), after=(values, "")))
    by_face = read(ply(face=channels(kind, names), after=("", values)))
    for part, says in (by_vertex, by_face):
        assert part.colors is not None
        assert np.allclose(part.colors[:, :3], RED, atol=1e-3)
        assert says == ()
    assert [len(part.positions) for part, _ in (by_vertex, by_face)] == [4, 6]


def test_triangle_strips() -> None:
    head = b"ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
    rows = b"0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 9 9\n"
    strips = b"element tristrips 2\nproperty list int int vertex_indices\nend_header\n"
    part, says = read(head + strips + rows + b"9 0 1 2 3 -1 2 3 4 -1\n3 0 1 2\n")
    assert part.triangles.tolist() == [[0, 1, 2], [2, 1, 3], [2, 3, 4], [0, 1, 2]]
    assert says == ()


def test_what_is_not_used_is_said() -> None:
    content = ply(
        vertex="property float quality\nproperty float s\n",
        face="property list uchar float texcoord\n",
        after=("1 2", "0"),
        more="element edge 1\nproperty int vertex1\nproperty int vertex2\ncomment TextureFile a.png\n",
        body="0 1\n",
    )
    assert read(content)[1] == (
        "element edge (1) is not shown and was ignored",
        "the texture of a PLY file is not supported and was ignored",
        "of element vertex, not used: quality, s",
        "of element face, not used: texcoord",
    )


def test_broken_normals_and_vertices_that_nothing_uses_cost_no_more_than_themselves() -> None:
    normals = channels("float", "nx ny nz")
    content = ply(vertex=normals, after=("0 0 nan", "")).replace(b"vertex 4", b"vertex 5").replace(
        b"\n3 0 1 2", b"\nnan nan nan 0 0 1\n3 0 1 2"
    )  # fmt: skip
    part, says = read(content)
    assert part.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert len(says) == 2


def test_what_has_no_positions_is_refused() -> None:
    with pytest.raises(SceneError, match="element vertex: x, y and z are not all there"):
        read(ply().replace(b"float z", b"float w"))

"""Parts of OBJ files: one a material and smoothing group, with normals of the file or without."""

import numpy as np

from gpu.scene.formats.obj.faces import ObjParts
from gpu.scene.formats.obj.statements import read_statements
from gpu.scene.remarks import Remarks

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 2\n"


def test_faces_with_normals_and_without_are_parts_of_their_own() -> None:
    text = SQUARE + "usemtl a\nf 1//1 2//1 3//1\nf 1 3 4\nusemtl b\nf 1//1 2//1 3//1 4//1\n"
    found = ObjParts(read_statements("a.obj", text, Remarks()), text, Remarks()).parts({"a": 4, "b": 7})
    assert [(part.material, part.name, len(part.triangles)) for part in found] == [
        (4, "a", 1),
        (4, "a", 1),
        (7, "b", 2),
    ]
    assert [part.normals is None for part in found] == [False, True, False]
    assert [len(part.positions) for part in found] == [3, 3, 4]
    assert all(part.uvs == () for part in found)


def test_corners_without_a_normal_get_that_of_their_smoothing_group() -> None:
    text = SQUARE + "s 1\nf 1//1 2 3\n"
    (part,) = ObjParts(read_statements("a.obj", text, Remarks()), text, Remarks()).parts({"": 0})
    assert part.normals is not None
    assert np.allclose(part.normals / np.linalg.norm(part.normals, axis=1)[:, None], (0, 0, 1))


def test_names_change_nothing_but_whose_the_vertices_are() -> None:
    text = SQUARE + "{}s 1\nusemtl a\nf 1 2 3\n{}f 1 3 4\n{}f 2 3 4\nusemtl b\nf 1//1 2//1 3//1 4//1\n"
    plain, named = text.format("", "", ""), text.format("o chair\n", "o table\n", "o chair\n")
    (a, b), (other_a, other_b) = (
        ObjParts(read_statements("a.obj", it, Remarks()), it, Remarks()).parts({"a": 0, "b": 1})
        for it in (plain, named)
    )
    for one, other in ((a, other_a), (b, other_b)):
        assert np.array_equal(one.positions[one.triangles], other.positions[other.triangles])
        assert one.normals is not None
        assert other.normals is not None
        assert np.array_equal(one.normals[one.triangles], other.normals[other.triangles])
    assert [part.owners[0] for part in (a, b, other_a, other_b)] == [("a",), ("b",), ("chair", "table"), ("chair",)]
    _, own = other_a.owners
    assert own[other_a.triangles].tolist() == [[0] * 3, [1] * 3, [0] * 3]  # corners of both are there twice
    assert len(other_a.positions) == 4 + 3

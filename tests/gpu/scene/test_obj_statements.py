"""Statements of OBJ files: rows keep their number, corners their indices, faces their material and smoothing group."""

import numpy as np

from gpu.scene.obj_statements import MOST_OBJECTS, read_statements, row_line
from gpu.scene.remarks import Remarks

TEXT = (
    "v 0 0 0\nv 1 0 0 1\nV 0 1 0\nvt 0.5\nvt 0 1 0\nvn 0 0 1\ns 3\nusemtl a  b\nf 1/1 2/2/1 3//1\ns off\nf -3 -2 -1\n"
)


def test_rows_corners_and_groups() -> None:
    remarks = Remarks()
    file = read_statements("a.obj", "mtllib x.mtl y.mtl\no name\n" + TEXT, remarks)
    assert file.table("v").tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert file.table("vt").tolist() == [[0.5, 0], [0, 1]]
    assert file.libraries == ["x.mtl y.mtl"]
    assert list(file.faces) == [("a b", 3), ("a b", 0)]
    corners = [[file.corners[number] for number in ids] for ids, _, _ in file.faces.values()]
    assert corners == [[(0, 0, -1), (1, 1, 0), (2, -1, 0)], [(0, -1, -1), (1, -1, -1), (2, -1, -1)]]
    assert file.lines == [11, 11, 11, 13, 13, 13]
    assert remarks.sentences() == ()


def test_negative_indices_mean_another_vertex_on_every_line() -> None:
    file = read_statements("a.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf -3 -2 -1\nv 0 0 0\nf -3 -2 -1\nf 2 3 4\n", Remarks())
    (ids, counts, _) = file.faces["", 0]
    assert np.array([file.corners[number][0] for number in ids]).reshape(3, 3).tolist() == [
        [0, 1, 2],
        [1, 2, 3],
        [1, 2, 3],
    ]
    assert counts.tolist() == [3, 3, 3]


def test_faces_are_of_the_last_object_or_else_group_that_is_named() -> None:
    names = ("", "G  a b", "o chair", "g seat", "o table", "o chair", "o", "usemtl wood")
    text = "v 0 0 0\n" + "".join(f"{name}\nf 1 1 1\n" for name in names)
    file = read_statements("a.obj", text, Remarks())
    assert file.objects == {"": 0, "a b": 1, "chair": 2, "table": 3, "seat": 4}
    owners = {material: owners.tolist() for (material, _), (_, _, owners) in file.faces.items()}
    assert owners == {"": [0, 1, 2, 2, 3, 2, 4], "wood": [4]}


def test_names_beyond_a_number_are_not_kept() -> None:
    text = "v 0 0 0\n" + "".join(f"g {number}\nf 1 1 1\n" for number in range(MOST_OBJECTS + 5))
    file = read_statements("a.obj", text, Remarks())
    assert len(file.objects) == MOST_OBJECTS + 1
    assert len(file.faces["", 0][2]) == MOST_OBJECTS + 5


def test_the_line_of_a_row() -> None:
    assert [row_line(TEXT, "v", row) for row in range(3)] == [1, 2, 3]
    assert row_line(TEXT, "vt", 1) == 5

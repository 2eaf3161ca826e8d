"""Statements of OBJ files: rows keep their number, corners their indices, faces their material and smoothing group."""

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.obj.blocks import LEAST
from gpu.scene.formats.obj.statements import MOST_OBJECTS, read_statements, row_line
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
    corners = [np.reshape(faces.corners, (-1, 3)).tolist() for faces in file.faces.values()]
    assert corners == [[[0, 0, -1], [1, 1, 0], [2, -1, 0]], [[0, -1, -1], [1, -1, -1], [2, -1, -1]]]
    assert [faces.lines.tolist() for faces in file.faces.values()] == [[11], [13]]
    assert remarks.sentences() == ()


def test_negative_indices_mean_another_vertex_on_every_line() -> None:
    file = read_statements("a.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf -3 -2 -1\nv 0 0 0\nf -3 -2 -1\nf 2 3 4\n", Remarks())
    faces = file.faces["", 0]
    assert np.reshape(faces.corners, (3, 3, 3))[:, :, 0].tolist() == [[0, 1, 2], [1, 2, 3], [1, 2, 3]]
    assert faces.counts.tolist() == [3, 3, 3]


def test_faces_are_of_the_last_object_or_else_group_that_is_named() -> None:
    names = ("", "G  a b", "o chair", "g seat", "o table", "o chair", "o", "usemtl wood")
    text = "v 0 0 0\n" + "".join(f"{name}\nf 1 1 1\n" for name in names)
    file = read_statements("a.obj", text, Remarks())
    assert file.objects == {"": 0, "a b": 1, "chair": 2, "table": 3, "seat": 4}
    owners = {material: faces.owners.tolist() for (material, _), faces in file.faces.items()}
    assert owners == {"": [0, 1, 2, 2, 3, 2, 4], "wood": [4]}


def test_names_beyond_a_number_are_not_kept() -> None:
    text = "v 0 0 0\n" + "".join(f"g {number}\nf 1 1 1\n" for number in range(MOST_OBJECTS + 5))
    file = read_statements("a.obj", text, Remarks())
    assert len(file.objects) == MOST_OBJECTS + 1
    assert len(file.faces["", 0].owners) == MOST_OBJECTS + 5


def test_the_line_of_a_row() -> None:
    assert [row_line(TEXT, "v", row) for row in range(3)] == [1, 2, 3]
    assert row_line(TEXT, "vt", 1) == 5


CORNERS = ("{0}", "{0}/{1}", "{0}//{2}", "{0}/{1}/{2}", "-{0}/-{1}/-{2}")


@pytest.mark.parametrize("corner", CORNERS)
def test_many_lines_at_once_say_what_they_do_one_by_one(corner: str) -> None:
    rng, lines = np.random.default_rng(3), []
    for _ in range(2):
        for key, width in (("v", 3), ("vt", 2), ("vn", 3), ("vt", 3), ("v", 6), ("v", 3)):
            lines += [f"{key}  {' '.join(map(repr, row))} " for row in rng.normal(size=(LEAST, width)).tolist()]
        for count in (3, 4, 5, *[3] * LEAST):
            words = (corner.format(*rng.integers(1, LEAST, 3)) for _ in range(count))
            lines.append("f " + "\t".join(words))
        lines += ["o table", "usemtl wood"]
    once, single = (
        read_statements("a.obj", "\n".join(wanted) + "\n", Remarks())
        for wanted in (lines, [line.replace("v", "V", 1).replace("f", "F", 1) for line in lines])
    )
    assert once == single
    assert len(once.rows["v"]) == 18 * LEAST
    assert [faces.lines[0] for faces in once.faces.values()] == [6 * LEAST + 1, 13 * LEAST + 6]


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ("v 1 2 3.4.5\n", f"line {LEAST + 1}: v needs 3 numbers"),
        ("f 1 2 0\n", f"line {LEAST + 1}: v index '0' does not exist, so far {LEAST}"),
        (f"f 1 2 -{LEAST + 1}\n", f"line {LEAST + 1}: v index '-{LEAST + 1}' does not exist, so far {LEAST}"),
    ],
)
def test_a_broken_line_among_many_is_named(lines: str, says: str) -> None:
    form = lines[0]
    rest = ("v 1 2 3\n" if form == "v" else "f 1 2 3\n") * LEAST
    with pytest.raises(SceneError, match=says):
        read_statements("a.obj", "v 0 0 0\n" * LEAST + lines + rest, Remarks())

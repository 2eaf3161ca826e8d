"""What readers of polygons share: broken positions that nothing uses, sentences on shapes."""

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.outlines import FaceMesh, covered, face_part, usable_positions, whole
from gpu.scene.remarks import Remarks

POSITIONS = np.array([[0.0, 0, 0], [np.nan, 0, 0], [1, 0, 0], [1e200, 0, 0], [0, 1, 0]])


def test_broken_positions_pass_where_nothing_uses_them() -> None:
    remarks = Remarks()
    assert usable_positions("a", POSITIONS, np.array([0, 2, 4]), remarks)[[1, 3]].tolist() == [[0, 0, 0], [0, 0, 0]]
    assert "left out (2)" in remarks.sentences()[0]


@pytest.mark.parametrize("broken", [1, 3])
def test_those_that_are_used_are_named(broken: int) -> None:
    with pytest.raises(SceneError, match=f"vertex {broken}: is not finite or too far away"):
        usable_positions("a", POSITIONS, np.array([0, broken, 4]), Remarks())


def test_shapes_that_are_no_polygon_are_counted() -> None:
    square, remarks = np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]]), Remarks()
    covered(square, np.array([0, 1, 0, 1, 2, 3]), np.array([2, 4]), remarks)
    assert remarks.sentences() == (
        "faces with fewer than 3 corners were left out (1)",
        "polygons that cross themselves: their shape is a guess (1)",
    )


def test_colours_of_faces_split_vertices() -> None:
    colors = np.array([[1.0, 0, 0, 1], [0, 1, 0, 1]])
    mesh = FaceMesh(np.eye(4, 3), np.array([0, 1, 2, 1, 2, 3]), np.array([3, 3]), np.ones((4, 3)), None, colors)
    part = face_part("a", mesh, Remarks())
    assert part.colors is not None
    assert part.normals is not None
    assert part.colors.tolist() == np.repeat(colors, 3, axis=0).tolist()
    assert (part.positions.shape, part.normals.shape) == ((6, 3), (6, 3))


def test_a_corner_that_does_not_exist_is_named_by_its_face() -> None:
    with pytest.raises(SceneError, match=r"face 1: index out of range: \[0, 1, 4\], there are 4 vertices"):
        face_part("a", FaceMesh(np.eye(4, 3), np.array([0, 1, 2, 0, 1, 4]), np.array([3, 3])), Remarks())


def test_what_is_no_index_is_out_of_range() -> None:
    found = whole(np.array([0.0, -1.0, 7.0, 1.5, np.nan, np.inf, 1e300]))
    assert found[:3].tolist() == [0, -1, 7]
    assert (found[3:] > 1e15).all()

"""What readers of polygons share: broken positions that nothing uses, sentences on shapes."""

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.outlines import covered, usable_positions
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

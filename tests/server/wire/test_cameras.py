from math import pi
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from server.wire.cameras import CameraChoice, view_of
from server.wire.worker import CameraMatrix, LookAt, SceneCamera, View

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
POINTS = {"position": [0, 1, 3], "target": [0, 1, 0]}
choice: TypeAdapter[Any] = TypeAdapter(CameraChoice)


@pytest.mark.parametrize(
    ("written", "view"),
    [
        (2, SceneCamera(2)),
        ("2", SceneCamera("2")),
        (POINTS, LookAt((0.0, 1.0, 3.0), (0.0, 1.0, 0.0), None, 60.0)),
        (POINTS | {"near": 4.5, "yfov_degrees": 40}, LookAt((0.0, 1.0, 3.0), (0.0, 1.0, 0.0), None, 40.0, 4.5)),
        ({"matrix": IDENTITY, "yfov_degrees": 90, "near": 4.5}, CameraMatrix(IDENTITY, pi / 2, 4.5)),
    ],
)
def test_a_camera_may_be_the_scenes_or_ones_own(written: object, view: View) -> None:
    assert view_of(choice.validate_python(written)) == view


@pytest.mark.parametrize(
    "written", [-1, 1.5, POINTS | {"near": -1}, {"matrix": [2.0, *IDENTITY[1:]]}, {"position": [0]}]
)
def test_what_is_no_camera_is_refused(written: object) -> None:
    with pytest.raises(ValidationError):
        choice.validate_python(written)

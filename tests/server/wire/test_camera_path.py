import pytest
from pydantic import ValidationError

from gpu.errors import UserError
from server.wire.browser import describe
from server.wire.camera_path import MAX_PICTURES, CameraPathSpec
from server.wire.worker import LookAt, SceneCamera

LOOK = {"position": [0, 1, 3], "target": [0, 1, 0]}


def spec(*times: float) -> CameraPathSpec:
    return CameraPathSpec.model_validate({"keyframes": [{"time": time, "camera": 0} for time in times]})


def test_pictures_are_evenly_spaced_from_the_first_keyframe_on() -> None:
    path = CameraPathSpec.model_validate(
        {"keyframes": [{"time": 1, "camera": LOOK, "name": "hall"}, {"time": 1.5, "camera": "door"}]}
    )
    views = path.views(8)
    assert path.seconds == 0.5
    assert [view.time for view in views] == [1.0, 1.125, 1.25, 1.375]
    assert views[0].keyframes == (
        (1.0, LookAt((0.0, 1.0, 3.0), (0.0, 1.0, 0.0), None, 60.0)),
        (1.5, SceneCamera("door")),
    )
    assert len(spec(0.0, 0.001).views(1)) == 1


@pytest.mark.parametrize(
    ("keyframes", "sentence"),
    [
        ([{"time": 0, "camera": 0}], "keyframes: needs 2 or more, has 1"),
        ([{"time": 0, "camera": 0}, {"time": 0, "camera": 1}], r"keyframes: times must increase; [1] has 0 after 0"),
        ([{"time": -1, "camera": 0}, {"time": 0, "camera": 1}], "keyframes.0.time: must be greater than or"),
        ([{"time": 0}, {"time": 1, "camera": 1}], "keyframes.0.camera: is missing"),
        ([{"time": 0, "camera": 0, "fov": 1}, {"time": 1, "camera": 1}], "keyframes.0.fov: is not known here"),
        (
            [{"time": 0, "camera": LOOK | {"yfov_degrees": 0}}, {"time": 1, "camera": 1}],
            "keyframes.0.camera.look-at.yf",
        ),
    ],
)
def test_what_is_wrong_is_named(keyframes: list[object], sentence: str) -> None:
    with pytest.raises(ValidationError) as caught:
        CameraPathSpec.model_validate({"keyframes": keyframes})
    assert describe(caught.value).startswith(sentence)


def test_a_film_has_an_end() -> None:
    with pytest.raises(UserError, match=f"3600 s are 108000 pictures at 30 a second, more than the {MAX_PICTURES}"):
        spec(0, 3600).views(30)
    assert len(spec(0, 3600).views(10)) == MAX_PICTURES
    last = spec(0, 3600).views(10)[-1:]
    assert [view.time for view in last] == [3599.9]
    with pytest.raises(IndexError):
        spec(0, 3600).views(10)[MAX_PICTURES]

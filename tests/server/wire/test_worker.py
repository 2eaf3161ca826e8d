import io

import pytest
from pydantic import ValidationError

from gpu.scene.edits import LightEdit, SceneEdits
from gpu.settings import Method, RenderSettings
from server.wire.browser import PickedPart
from server.wire.worker import (
    MAX_TEXT_BYTES,
    AlongPath,
    CameraMatrix,
    CameraSpec,
    Cause,
    Done,
    Export,
    Exported,
    Failed,
    FromWorker,
    LookAt,
    Pick,
    Picked,
    Render,
    SceneCamera,
    SceneRef,
    Start,
    ToWorker,
    pack,
    read,
)

SCENE = SceneRef("hall.glb", "/somewhere/hall.glb", 12)


@pytest.mark.parametrize(
    "view",
    [
        SceneCamera(2),
        SceneCamera("2"),
        LookAt((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 45.0),
        CameraMatrix(tuple(float(number) for number in range(16)), 1.0),
        AlongPath(((0.0, SceneCamera("hall")), (2.5, LookAt((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), None, 45.0, 0.5))), 1.25),
    ],
)
def test_a_render_crosses_the_border_as_it_is(view: CameraSpec) -> None:
    job = Render(3, SCENE, view, (64, 36), RenderSettings(method=Method.PATH, samples=9), "jpeg", request=5)
    assert read(io.BytesIO(pack(job))) == (job, b"")


@pytest.mark.parametrize(
    "message",
    [
        Start(SCENE),
        Failed(1, "bad", Cause.USER),
        Done(2, (1, 2), 3.0, 4.0, 1, 1, {"a": 1.0}, {}, {}),
        Pick(SCENE, SceneCamera(0), (64, 36), (0.25, 0.5), SceneEdits(lights={"lamp": LightEdit(on=False)})),
        Export(SCENE, SceneEdits(lights={"lamp": LightEdit(on=False)})),
        Exported(4),
        Picked(3, PickedPart(object="chair", point=(1.0, 2.0, 3.0), distance=4.0)),
    ],
)
def test_messages_and_bytes_follow_each_other(message: ToWorker | FromWorker) -> None:
    pipe = io.BytesIO(pack(message, b"\x00\xff") + pack(message))
    assert read(pipe) == (message, b"\x00\xff")
    assert read(pipe) == (message, b"")
    with pytest.raises(EOFError):
        read(pipe)


def test_a_cut_message_is_the_end() -> None:
    with pytest.raises(EOFError):
        read(io.BytesIO(pack(Start(SCENE), b"bytes")[:-1]))


@pytest.mark.parametrize(
    "stages", [{"a": float("nan")}, {"a": -1.0}, {"": 1.0}, {33 * "a": 1.0}, {str(number): 1.0 for number in range(65)}]
)
def test_stages_that_cannot_be_told_to_a_browser_are_refused(stages: dict[str, float]) -> None:
    with pytest.raises(ValidationError, match="stage_ms"):
        read(io.BytesIO(pack(Done(2, (1, 2), 3.0, 4.0, 1, 1, stages, {}, {}))))


def test_what_the_other_side_would_refuse_is_not_sent() -> None:
    empty = len(pack(Failed(1, "", Cause.USER))) - 8
    assert len(pack(Failed(1, "n" * (MAX_TEXT_BYTES - empty), Cause.USER))) == MAX_TEXT_BYTES + 8
    with pytest.raises(ValueError, match=r"more than a message may have: failed$"):
        pack(Failed(1, "n" * (MAX_TEXT_BYTES - empty + 1), Cause.USER))


def test_what_is_not_a_message_is_refused() -> None:
    text = b'{"kind": "obey"}'
    with pytest.raises(ValidationError):
        read(io.BytesIO(len(text).to_bytes(4, "little") + bytes(4) + text))

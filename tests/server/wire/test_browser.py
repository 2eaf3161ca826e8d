import json
import math

import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.renderer import Renderer
from gpu.scene import load_scene
from gpu.settings import RenderSettings
from server.wire.browser import (
    HEADER_BYTES,
    STAGES,
    Ack,
    FrameHeader,
    Pose,
    Settings,
    parse_viewer_message,
    stage_slots,
    unpack_frame,
)

IDENTITY = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def test_a_header_survives_the_wire_and_keeps_the_image_aligned() -> None:
    header = FrameHeader(640, 360, 7, 2**32 - 1, 3, 0.5, 12.25, 1.5, tuple(0.5 * k for k in range(12)))
    message = header.pack() + b"image"
    assert unpack_frame(message) == (header, b"image")
    assert HEADER_BYTES == 88


def test_the_header_has_the_documented_layout() -> None:
    packed = FrameHeader(0x0102, 0x0304, 5, 6, 7, 0.0, 0.0, 0.0, (0.0,) * len(STAGES)).pack()
    assert packed[:20] == bytes([2, 1, 88, 0, 2, 1, 4, 3, 5, 0, 0, 0, 6, 0, 0, 0, 7, 0, 0, 0])


@pytest.mark.parametrize("message", [b"", b"\x02" * 87, b"\x01" + bytes(96)])
def test_what_is_not_a_frame_is_refused(message: bytes) -> None:
    with pytest.raises(UserError, match="not a frame"):
        unpack_frame(message)


def test_stages_without_a_slot_are_summed_in_the_last_one() -> None:
    slots = stage_slots({"shade": 2.0, "unheard-of": 1.0, "gbuffer": 3.0, "another": 0.5})
    assert dict(zip(STAGES, slots, strict=True)) == dict.fromkeys(STAGES, 0.0) | {
        "gbuffer": 3,
        "shade": 2,
        "other": 1.5,
    }


def test_every_stage_of_a_frame_in_motion_but_its_end_has_a_slot() -> None:
    resident = DeviceScene(load_scene("cornell-box"), "cpu")
    settings = RenderSettings(sp_clusters=16, vpl_clusters=8, vpls=64)
    stages = Renderer(resident, (16, 12), settings).render(resident.scene.cameras[0]).stats.stage_ms
    assert [*stages] == [*STAGES[:-1], "keep", "display"]


def test_messages_are_typed() -> None:
    assert parse_viewer_message('{"type": "ack", "frame": 3}') == Ack(type="ack", frame=3)
    pose = parse_viewer_message(json.dumps({"type": "pose", "id": 1, "matrix": IDENTITY, "yfov": 1.0}))
    assert isinstance(pose, Pose)
    settings = parse_viewer_message('{"type": "settings", "id": 2, "settings": {"method": "path"}}')
    assert isinstance(settings, Settings)
    assert settings.size is None


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("{", "Invalid JSON"),
        ("[]", "object"),
        ('{"type": "dance"}', "dance"),
        ('{"type": "ack", "frame": 1, "extra": 1}', "ack.extra"),
        ('{"type": "ack", "frame": 4294967296}', "ack.frame"),
        ('{"type": "hello", "protocol": 2, "size": [8, 8]}', "hello.protocol"),
        ('{"type": "hello", "protocol": 1, "size": [0, 8]}', "hello.size.0"),
        ('{"type": "settings", "id": 1, "settings": {"vpls": -1}}', "settings.settings.vpls"),
    ],
)
def test_wrong_messages_are_refused_with_the_field(text: str, complaint: str) -> None:
    with pytest.raises(UserError, match=complaint):
        parse_viewer_message(text)


@pytest.mark.parametrize(
    "change",
    [
        {0: 2.0},  # scaled
        {0: -1.0},  # mirrored
        {1: 0.5},  # sheared
        {3: 1.0},  # projective
        {12: math.inf},
        {12: 1e300},
        {10: math.nan},
    ],
)
def test_a_pose_is_a_rotation_and_a_translation(change: dict[int, float]) -> None:
    matrix = [change.get(index, value) for index, value in enumerate(IDENTITY)]
    with pytest.raises(UserError, match=r"pose\.matrix"):
        parse_viewer_message(json.dumps({"type": "pose", "id": 1, "matrix": matrix, "yfov": 1.0}))


def test_a_turned_pose_is_taken() -> None:
    c, s = math.cos(0.7), math.sin(0.7)
    matrix = [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 5, 6, 7, 1]
    assert isinstance(parse_viewer_message(json.dumps({"type": "pose", "id": 1, "matrix": matrix, "yfov": 1})), Pose)

import json
import math

import pytest

from gpu.errors import UserError
from server.wire.browser import Ack, Pose, Settings, parse_viewer_message

IDENTITY = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]


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
        ('{"type": "hello", "protocol": 1, "size": [8, 8]}', "hello.protocol"),
        ('{"type": "hello", "protocol": 2, "size": [0, 8]}', "hello.size.0"),
        ('{"type": "settings", "id": 1, "settings": {"vpls": -1}}', "settings.settings.vpls"),
        ('{"type": "settings", "id": 1, "settings": {"exposure": NaN}}', "exposure: .* finite .*above 0 and"),
        (json.dumps({"type": "pose", "id": 1, "matrix": IDENTITY, "yfov": math.nan}), "pose.yfov: must be a finite"),
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

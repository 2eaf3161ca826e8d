from dataclasses import replace

import numpy as np
import pytest

from gpu.scene.animation import pose as posing
from gpu.scene.animation.motion import (
    STILL,
    Animation,
    Body,
    Channel,
    Interpolation,
    MorphTarget,
    Motion,
    Property,
    Skin,
)
from gpu.scene.animation.pose import Pose, all_in_world, at_rest, in_world, pose_at
from gpu.scene.scene_parts import MeshPart

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
UP = np.tile([[0.0, 0.0, 1.0]], (3, 1))
PART = MeshPart(CORNERS, np.array([[0, 1, 2]]), UP)
BODY = Body(0, CORNERS, UP, PART.triangles, np.eye(4)[None])
REST = np.array([0, 0, 0, 0, 0, 0, 1, 1, 1, 1], np.float64)


def moved(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def slides(node: int, changes: Property, values: list[list[float]]) -> Channel:
    """From the first value to the second in a second."""
    return Channel(node, changes, Interpolation.LINEAR, np.array([0.0, 1.0]), np.array(values)[:, None])


def test_nodes_move_with_those_that_they_are_in() -> None:
    local = np.stack([np.eye(4), moved(0, 1, 0), moved(0, 0, 1)])
    slide, grow = [[0, 0, 0], [8, 0, 0]], [[1, 1, 1], [3, 3, 3]]
    channels = slides(0, Property.TRANSLATION, slide), slides(0, Property.SCALE, grow)
    parents, animation = np.array([STILL, 0, STILL], np.int32), Animation("a", 1.0, channels)
    motion = Motion(parents, local, np.tile(REST, (3, 1)), (animation,))
    pose = pose_at(motion, motion.animations[0], 0.5)
    assert pose.to_world[:, :3, 3].tolist() == [[4, 0, 0], [4, 2, 0], [0, 0, 1]]
    assert np.array_equal(at_rest(motion).to_world[1], moved(0, 1, 0))


def test_weights_bend_what_hangs_on_their_node() -> None:
    targets = MorphTarget(UP * 2.0, None), MorphTarget(None, UP * 3.0)
    body = replace(BODY, targets=targets, weights=(1.0, 0.0))
    rest = in_world(PART, body, Pose(np.eye(4)[None]))
    assert rest.positions[:, 2].tolist() == [2.0] * 3
    bent = in_world(PART, body, Pose(np.eye(4)[None], {0: [0.5, 2.0]}))
    assert bent.positions[:, 2].tolist() == [1.0] * 3
    assert bent.normals is not None
    assert bent.normals[:, 2].tolist() == [7.0] * 3


def test_instances_are_placed_in_their_node() -> None:
    body = replace(BODY, instances=np.stack([np.eye(4), moved(0, 5, 0)]))
    found = in_world(PART, body, Pose(moved(1, 0, 0)[None]))
    assert np.array_equal(found.positions, np.concatenate([CORNERS + np.array([1, y, 0]) for y in (0, 5)]))


def test_skinned_vertices_follow_their_joints_by_their_shares() -> None:
    skin = Skin(np.array([1, 2], np.int32), np.stack([np.eye(4), moved(0, 0, -1)]))
    shares = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]])
    body = replace(BODY, skin=skin, joints=np.array([[0, 1]] * 3, np.int32), shares=shares)
    turn = np.diag([1.0, -1.0, -1.0, 1.0])
    found = in_world(PART, body, Pose(np.stack([moved(99, 99, 99), moved(0, 0, 2), turn])))
    assert found.positions.tolist() == [[0.0, 0.0, 2.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.5]]
    assert found.normals is not None
    assert found.normals[:2].tolist() == [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]


def test_parts_together_are_as_each_alone_and_in_their_order() -> None:
    pose = Pose(np.stack([moved(1, 2, 3), np.diag([-2.0, 1.0, 1.0, 1.0])]), {1: [0.5]})
    joints, shares = np.zeros((3, 1), np.int32), np.ones((3, 1))
    bodies = [
        BODY,
        replace(BODY, skin=Skin(np.array([1]), np.eye(4)[None]), joints=joints, shares=shares),
        replace(BODY, node=1, targets=(MorphTarget(UP, None),)),
        replace(BODY, instances=np.stack([np.eye(4), moved(0, 0, 9)])),
        replace(BODY, node=1),
    ]
    for found, body in zip(all_in_world([(PART, body) for body in bodies], pose), bodies, strict=True):
        alone = in_world(PART, body, pose)
        assert np.array_equal(found.positions, alone.positions)
        assert np.array_equal(found.triangles, alone.triangles)
        assert np.array_equal(found.normals, alone.normals)


def test_all_nodes_that_move_are_composed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = []
    compose = posing.compose
    monkeypatch.setattr(posing, "compose", lambda *parts: rows.append(len(parts[0])) or compose(*parts))
    channels = tuple(slides(node, Property.TRANSLATION, [[0, 0, 0], [8, 0, 0]]) for node in range(5))
    motion = Motion(np.full(5, STILL), np.tile(np.eye(4), (5, 1, 1)), np.tile(REST, (5, 1)), ())
    pose_at(motion, Animation("a", 1.0, channels), 0.5)
    assert rows == [5]

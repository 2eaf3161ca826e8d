import numpy as np

from gpu.scene.default_view import default_camera
from gpu.scene.types import Camera, Placement

BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.2, 0.2) for z in (-0.3, 0.3)], np.float32)
OUTWARD = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
WORLD = Placement((10.0, 0.0, 0.0), 0.1)


def eye_and_direction(camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """In unit space."""
    return (camera.to_world[:3, 3] - WORLD.centre) * WORLD.scale, -camera.to_world[:3, 2]


def test_an_object_is_seen_whole_from_outside() -> None:
    camera = default_camera(BOX, OUTWARD, WORLD)
    eye, direction = eye_and_direction(camera)
    assert (np.abs(eye) > (0.5, 0.2, 0.3)).any()
    towards = BOX - eye
    depth = towards @ direction
    assert (depth > 0).all()
    sideways = np.linalg.norm(towards - depth[:, None] * direction, axis=1)
    assert (sideways / depth <= camera.half_height + 1e-6).all()


def test_a_room_is_seen_from_inside_with_its_middle_ahead() -> None:
    eye, direction = eye_and_direction(default_camera(BOX, OUTWARD[:, ::-1], WORLD))
    assert (np.abs(eye) < (0.5, 0.2, 0.3)).all()
    assert np.linalg.norm(eye) > 0.25  # away from the middle
    assert np.dot(direction, -eye) > 0.9 * np.linalg.norm(eye)


def test_a_flat_scene_has_a_view_too() -> None:
    camera = default_camera(BOX[[0, 1, 4, 5]], np.array([[0, 1, 2], [1, 3, 2]]), WORLD)
    assert np.isfinite(camera.to_world).all()


def test_a_house_on_a_lawn_is_no_room() -> None:
    """Below the horizon the lawn is everywhere, and beside the house its wall is, too."""
    lawn = np.array([[-0.5, -0.05, -0.5], [-0.5, -0.05, 0.5], [0.5, -0.05, 0.5], [0.5, -0.05, -0.5]])
    house = BOX * (0.25, 0.5, 0.4) + (0.0, 0.05, 0.0)
    vertices = np.vstack([house, lawn]).astype(np.float32)
    camera = default_camera(vertices, np.vstack([OUTWARD, [[8, 9, 10], [8, 10, 11]]]), WORLD)
    eye, direction = eye_and_direction(camera)
    assert eye[1] > 0.15
    assert np.dot(direction, -eye) > 0.9 * np.linalg.norm(eye)

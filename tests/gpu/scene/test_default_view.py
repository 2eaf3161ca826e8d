from itertools import product

import numpy as np
import pytest
import trimesh

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


def test_nobody_looks_out_from_between_the_pieces_of_an_exhibit() -> None:
    """Balls in rows and layers, half a metre wide together: their fronts are all around the gaps between them."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.3)
    places = np.array(list(product((-2, -1, 0, 1, 2), (-2, -1, 0, 1, 2), (-1, 0, 1))), float)
    vertices = np.concatenate([ball.vertices + place for place in places]).astype(np.float32) / 5.0
    triangles = np.concatenate([ball.faces + len(ball.vertices) * number for number in range(len(places))])
    camera = default_camera(vertices, triangles, Placement((0.0, 0.0, 0.0), 2.0))
    assert np.linalg.norm(camera.to_world[:3, 3]) > np.linalg.norm(vertices, axis=1).max() / 2.0


def test_walls_of_glass_make_no_room() -> None:
    """Nor do blocks of glass in rows before a backdrop."""
    inside, triangles = (0.5, 0.2, 0.3), OUTWARD[:, ::-1]
    for glass, room in (([False] * 12, True), ([True] * 10 + [False] * 2, False), ([True] * 12, False)):
        eye, _ = eye_and_direction(default_camera(BOX, triangles, WORLD, np.array(glass)))
        assert (np.abs(eye) < inside).all() == room


@pytest.mark.parametrize("metre", [1.0, 4.0])
def test_a_view_of_a_room_is_that_of_a_standing_person(metre: float) -> None:
    """A hall of two storeys; nobody stands in one of the size of a doll's house."""
    size = np.array([12.0, 6.5, 9.0])
    lower, upper = (BOX / (1.0, 0.4, 0.6) * size * (1, 3 / 6.5, 1) + (0, y, 0) for y in (-1.75, 1.75))
    vertices = np.concatenate([lower, upper]).astype(np.float32) / 12.0
    placement = Placement((0.0, 0.0, 0.0), metre / 12.0)
    camera = default_camera(vertices, np.vstack([OUTWARD[:, ::-1], 8 + OUTWARD[:, ::-1]]), placement)
    height = camera.to_world[1, 3] * metre
    above = (height + 3.25) % 3.5 / metre
    assert (abs(above - 1.6) < 1e-3) == (metre == 1.0)
    assert abs(camera.to_world[1, 2]) < 1e-6


def test_a_mountain_has_no_floor_to_walk() -> None:
    vertices = BOX.astype(np.float32)
    for height, person in ((290.0, True), (310.0, False)):
        placement = Placement((0.0, 0.0, 0.0), 0.4 / height)
        eye = default_camera(vertices, OUTWARD[:, ::-1], placement).to_world[1, 3]
        assert (abs(eye + height / 2 - 1.6) < 0.1) == person


def test_a_corridor_that_nobody_is_meant_to_see_is_not_chosen() -> None:
    """It is the longest view of the scene, but the hall beside it has most room around."""
    parts = [BOX * (12.0, 7.5, 10.0), BOX * (16.0, 7.5, 2.5) + (0.0, 0.0, 6.0)]
    vertices = np.concatenate(parts).astype(np.float32) / 16.0
    camera = default_camera(
        vertices, np.vstack([OUTWARD[:, ::-1], 8 + OUTWARD[:, ::-1]]), Placement((0.0, 0.0, 0.0), 1.0 / 16.0)
    )
    eye = camera.to_world[:3, 3]
    assert abs(eye[2]) < 3.0
    assert np.linalg.norm(eye[[0, 2]]) > 1.0
    assert np.dot(camera.to_world[:3, 2], eye) > 0.0

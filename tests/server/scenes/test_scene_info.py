from dataclasses import replace
from math import atan

import numpy as np
import pytest

from gpu.scene.load import load_scene
from gpu.scene.types import Camera, LoadReport, Placement, Scene
from server.scenes.scene_info import describe_scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A scene 10 m wide around (100, 0, 0)."""
    vertices = np.array([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5], [0.5, -0.5, 0.0]], np.float32)
    placement, bounds = Placement(centre=(100.0, 0.0, 0.0), scale=0.1), ((95.0, -5.0, -5.0), (105.0, 5.0, 5.0))
    to_world = np.eye(4)
    to_world[:3, 3] = (100.0, 0.0, 20.0)
    cameras = (
        Camera("eye", to_world, half_height=0.5, near=4.0),
        Camera("plan", to_world, half_height=4.0, orthographic=True),
    )
    report = LoadReport(ignored=("a fog was ignored",), dropped_triangles=2)
    box = load_scene("cornell-box")
    triangles = np.array([[0, 1, 2]], np.int32)
    return replace(
        box,
        name="test",
        vertices=vertices,
        triangles=triangles,
        placement=placement,
        bounds=bounds,
        cameras=cameras,
        report=report,
    )


def test_bounds_are_in_world_space(scene: Scene) -> None:
    bounds = describe_scene("id", scene).bounds
    assert bounds.min == pytest.approx((95.0, -5.0, -5.0))
    assert bounds.max == pytest.approx((105.0, 5.0, 5.0))


def test_cameras_are_column_major(scene: Scene) -> None:
    camera = describe_scene("id", scene).cameras[0]
    assert camera.matrix[12:15] == (100.0, 0.0, 20.0)
    assert camera.yfov == pytest.approx(2.0 * atan(0.5))
    assert camera.near == 4.0


def test_an_orthographic_camera_becomes_one_that_shows_as_much(scene: Scene) -> None:
    camera = describe_scene("id", scene).cameras[1]
    assert camera.orthographic
    assert camera.yfov == pytest.approx(2.0 * atan(4.0 / 20.0))


def test_what_was_ignored_or_dropped_is_said(scene: Scene) -> None:
    info = describe_scene("rooms/hall.glb", scene)
    assert info.notes == ("a fog was ignored", "2 triangles without area were dropped")
    assert (info.id, info.triangles) == ("rooms/hall.glb", 1)


def test_a_scene_is_called_by_its_id_not_by_its_path(scene: Scene) -> None:
    assert describe_scene("rooms/hall.glb", replace(scene, name="/private/rooms/hall.glb")).name == "hall"

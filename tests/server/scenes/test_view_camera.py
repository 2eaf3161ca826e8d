from dataclasses import replace

import numpy as np
import pytest

from gpu.errors import UserError
from gpu.scene.file_frame import FileFrame
from gpu.scene.load import load_scene
from server.scenes.scene_info import MOST_CAMERAS, describe_scene
from server.scenes.view_camera import camera_path, check_view, view_camera
from server.wire.worker import AlongPath, CameraMatrix, LookAt, SceneCamera

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
LOOKING = LookAt((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), None, 90.0)


def test_views_become_cameras() -> None:
    scene = load_scene("cornell-box")
    by_index, by_name = (view_camera(scene, SceneCamera(key), (40, 10)) for key in (0, scene.cameras[0].name))
    assert by_index.aspect == 4.0
    np.testing.assert_array_equal(by_index.to_world, by_name.to_world)
    placed = view_camera(scene, CameraMatrix((*IDENTITY[:12], 1.0, 2.0, 3.0, 1.0), np.pi / 2, 0.5), (10, 10))
    assert placed.near == 0.5
    np.testing.assert_array_equal(placed.to_world[:3, 3], (1.0, 2.0, 3.0))
    assert placed.half_height == pytest.approx(1.0)
    looking = view_camera(scene, LookAt((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 90.0), (10, 10))
    np.testing.assert_allclose(looking.to_world[:3, 3], (0.0, 0.0, 5.0))
    assert looking.half_height == pytest.approx(1.0)


def test_a_view_is_given_in_the_coordinates_of_the_file() -> None:
    survey = replace(load_scene("cornell-box"), frame=FileFrame("z", 0.001, (456_789_000.0, 5_432_100_000.0, 0.0)))
    there, north = (456_790_500.0, 5_432_102_000.0, 1600.0), (456_790_500.0, 5_432_103_000.0, 1600.0)
    level = view_camera(survey, LookAt(there, north, None, 90.0), (10, 10)).to_world
    np.testing.assert_allclose(level[:3, 3], (1.5, 1.6, -2.0))
    np.testing.assert_allclose(level[:3, :3], np.eye(3), atol=1e-12)
    on_its_side = view_camera(survey, LookAt(there, north, (1.0, 0.0, 0.0), 90.0), (10, 10)).to_world
    np.testing.assert_allclose(on_its_side[:3, 1], (1.0, 0.0, 0.0), atol=1e-12)


def test_a_view_from_a_point_may_cut_away_what_is_near() -> None:
    looking = LookAt((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), None, 90.0, 0.5)
    assert view_camera(load_scene("cornell-box"), looking, (10, 10)).near == 0.5


def test_a_path_leads_from_view_to_view() -> None:
    scene = load_scene("cornell-box")
    there = LookAt((1.0, 1.0, 1.0), (0.0, 1.0, 0.0), None, 60.0)
    keyframes = ((1.0, SceneCamera(0)), (3.0, there))
    start, middle, end = (view_camera(scene, AlongPath(keyframes, time), (20, 10)) for time in (1.0, 2.0, 3.0))
    assert start.aspect == 2.0
    np.testing.assert_allclose(start.to_world, scene.cameras[0].to_world, atol=1e-12)
    np.testing.assert_allclose(end.to_world, view_camera(scene, there, (20, 10)).to_world, atol=1e-12)
    np.testing.assert_allclose(middle.to_world[:3, 3], (start.to_world[:3, 3] + end.to_world[:3, 3]) / 2)


def test_a_keyframe_that_the_scene_lacks_is_named() -> None:
    path = AlongPath(((0.0, SceneCamera(0)), (1.0, SceneCamera("attic"))), 0.0)
    with pytest.raises(UserError, match=r"^keyframes\[1\]\.camera: .* no camera 'attic'; it has 0 \("):
        camera_path(load_scene("cornell-box"), path, (10, 10))


def test_a_camera_that_is_not_listed_is_missed_before_the_scene_is_there() -> None:
    scene = load_scene("cornell-box")
    info = describe_scene("box", scene)
    there = AlongPath(((0.0, SceneCamera(0)), (1.0, SceneCamera(scene.cameras[0].name)), (2.0, LOOKING)), 0.0)
    check_view(info, there)
    for wrong in ("attic", 9, "0"):
        with pytest.raises(UserError, match=rf"^camera: box has no camera {wrong!r}; it has 0 \("):
            check_view(info, SceneCamera(wrong))
    with pytest.raises(UserError, match=r"^keyframes\[1\]\.camera: box has no camera 'attic'"):
        check_view(info, AlongPath(((0.0, SceneCamera(0)), (1.0, SceneCamera("attic"))), 0.0))
    check_view(info.model_copy(update={"cameras": info.cameras * MOST_CAMERAS}), SceneCamera("attic"))

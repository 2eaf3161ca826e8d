from dataclasses import replace

import numpy as np
import pytest

from gpu.errors import UserError
from gpu.scene.file_frame import FileFrame
from gpu.scene.types import Camera, Material, Placement, Scene
from server.cli.camera_argument import choose_camera, parse_size


@pytest.fixture
def scene() -> Scene:
    """A triangle with two cameras, of which the second has a number for a name."""
    cameras = tuple(Camera(name, np.eye(4), half_height=height) for name, height in (("door", 0.5), ("0", 0.7)))
    return Scene(
        name="room",
        vertices=np.zeros((3, 3), np.float32),
        normals=np.ones((3, 3), np.float32),
        uvs=np.zeros((1, 3, 2), np.float32),
        colors=None,
        triangles=np.array([[0, 1, 2]], np.int32),
        triangle_material=np.zeros(1, np.int32),
        materials=(Material(),),
        textures=(),
        lights=(),
        sky=None,
        cameras=cameras,
        placement=Placement(),
        bounds=((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
    )


def test_size() -> None:
    assert parse_size("960x540") == (960, 540)
    assert parse_size("1X1") == (1, 1)


@pytest.mark.parametrize("text", ["", "960", "960x", "axb", "1x2x3", "0x5", "5x-1", "99999x2", "1.5x2"])
def test_bad_sizes_are_said(text: str) -> None:
    with pytest.raises(UserError, match="--size"):
        parse_size(text)


@pytest.mark.parametrize(("text", "half_height"), [("door", 0.5), ("1", 0.7), ("0", 0.7)])
def test_camera_by_name_then_number(scene: Scene, text: str, half_height: float) -> None:
    camera = choose_camera(scene, text, aspect=2.0)
    assert camera.half_height == half_height
    assert camera.aspect == 2.0


def test_camera_by_position(scene: Scene) -> None:
    camera = choose_camera(scene, "0,1,5:0,1,0:90", aspect=1.5)
    assert camera.to_world[:3, 3] == pytest.approx([0.0, 1.0, 5.0])
    assert camera.to_world[:3, 2] == pytest.approx([0.0, 0.0, 1.0])
    assert camera.half_height == pytest.approx(1.0)
    assert camera.aspect == 1.5
    assert choose_camera(scene, "0,1,5:0,1,0", aspect=1.0).half_height == pytest.approx(3.0**-0.5)


@pytest.mark.parametrize("text", ["window", "2", "-1", "1,2,3"])
def test_an_unknown_camera_lists_the_known(scene: Scene, text: str) -> None:
    with pytest.raises(UserError, match="0 'door', 1 '0'"):
        choose_camera(scene, text, aspect=1.0)


@pytest.mark.parametrize("text", ["1,2:3,4,5", "1,2,3:4,5,x", "1,2,3:4,5,6:7,8", "1,2,3:4,5,6:7:8", ":", "1,1,1:1,1,1"])
def test_bad_positions_are_said(scene: Scene, text: str) -> None:
    with pytest.raises(UserError, match="camera"):
        choose_camera(scene, text, aspect=1.0)


def test_points_are_in_the_coordinates_of_the_file(scene: Scene) -> None:
    survey = replace(scene, frame=FileFrame("z", 0.001, (456_789_000.0, 5_432_100_000.0, 120_000.0)))
    camera = choose_camera(survey, "456790500,5432102000,121600:456790500,5432103000,121600", 1.0)
    assert np.allclose(camera.to_world[:3, 3], (1.5, 1.6, -2.0))
    assert np.allclose(camera.to_world[:3, 2], (0.0, 0.0, 1.0))  # looks north, which is −Z

from typing import Any

import numpy as np
import pytest

from gpu.errors import UserError
from gpu.scene.camera import CameraError, look_at


def test_looks_along_minus_z_by_default_axes() -> None:
    camera = look_at((1, 2, 3), (1, 2, -7), name="front")
    expected = np.eye(4)
    expected[:3, 3] = (1, 2, 3)
    np.testing.assert_allclose(camera.to_world, expected, atol=1e-12)
    assert camera.name == "front"
    assert camera.half_height == pytest.approx(np.tan(np.pi / 6))


@pytest.mark.parametrize("target", [(4, 1, 2), (-3, 5, 0.5), (0, 0, 9)])
def test_is_a_rotation_that_maps_forward_to_the_target(target: tuple[float, float, float]) -> None:
    eye = np.array([0.3, 1.6, -2.0])
    matrix = look_at(eye, target).to_world
    rotation = matrix[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    forward = (np.array(target) - eye) / np.linalg.norm(np.array(target) - eye)
    np.testing.assert_allclose(-rotation[:, 2], forward, atol=1e-12)
    assert rotation[1, 1] > 0.0  # the picture's top is up
    assert rotation[1, 0] == pytest.approx(0.0)  # and its horizon is level


def test_scenes_may_be_as_large_as_they_are_read() -> None:
    camera = look_at((3e100, 0, 0), (0, 0, 0))
    np.testing.assert_allclose(camera.to_world[:3, :3] @ camera.to_world[:3, :3].T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(("target", "up"), [((0, -5, 0), (0, 1, 0)), ((0, 5, 0), (0, 1, 0)), ((0, 0, 4), (0, 0, 1))])
def test_view_along_up_still_has_a_frame(target: tuple[float, float, float], up: tuple[float, float, float]) -> None:
    rotation = look_at((0, 0, 0), target, up).to_world[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(-rotation[:, 2], np.array(target) / np.linalg.norm(target), atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"target": (0, 0, 0)}, "target"),
        ({"target": (0, 0, float("nan"))}, "target"),
        ({"eye": (0, 0)}, "eye"),
        ({"eye": (1e300, 0, 0)}, "eye: needs numbers of up to 1e"),
        ({"target": (0, -1e200, 0)}, "target: needs numbers of up to 1e"),
        ({"up": (0, 0, 0)}, "up"),
        ({"yfov_degrees": 0.0}, "field of view"),
        ({"yfov_degrees": 180.0}, "field of view"),
        ({"yfov_degrees": float("nan")}, "field of view"),
        ({"aspect": 0.0}, "aspect"),
        ({"aspect": float("inf")}, "aspect"),
    ],
)
def test_names_what_is_wrong(arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(CameraError, match=word) as error:
        look_at(**{"eye": (0, 0, 0), "target": (0, 0, -1)} | arguments)
    assert isinstance(error.value, UserError)

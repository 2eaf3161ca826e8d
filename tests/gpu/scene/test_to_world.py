import numpy as np
import pytest

from gpu.scene.file_frame import FileFrame
from gpu.scene.to_world import camera_in_world, light_in_unit_space
from gpu.scene.types import Camera, Light, LightKind, Placement

FRAME = FileFrame("z", 0.01, (100.0, 0.0, 0.0))


def test_a_camera_turns_and_scales_with_the_file() -> None:
    plan = Camera("plan", np.eye(4), 100.0, orthographic=True)
    plan.to_world[:3, 3] = (300.0, 100.0, 300.0)
    camera = camera_in_world(plan, FRAME)
    assert np.allclose(camera.to_world[:3, 3], (2.0, 3.0, -1.0))
    assert np.allclose(camera.to_world[:3, 2], (0.0, 1.0, 0.0))
    assert camera.half_height == 1.0
    assert np.array_equal(plan.to_world[:3, :3], np.eye(3))


@pytest.mark.parametrize(("said", "intensity"), [(0.01, 0.25), (1.0, 0.25e-4)], ids=["said", "guessed"])
def test_a_guess_of_the_unit_leaves_what_lamps_do_as_it_is(said: float, intensity: float) -> None:
    """A lamp 2 m away, in unit space 1, has the same irradiance there; in the file's own units that was 200 away."""
    lamp = Light("lamp", LightKind.POINT, (1.0, 1.0, 1.0), (300.0, 0.0, 100.0), (0.0, 0.0, -1.0))
    placed = light_in_unit_space(lamp, FRAME, Placement((0.0, 0.0, 0.0), 0.5), said)
    assert np.allclose(placed.position, (1.0, 0.5, 0.0))
    assert np.allclose(placed.direction, (0.0, -1.0, 0.0))
    assert np.allclose(placed.intensity, intensity)


def test_a_directional_light_only_turns() -> None:
    sun = Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, 1.0, 0.0))
    assert light_in_unit_space(sun, FRAME, Placement(), 1.0).direction == (0.0, 0.0, -1.0)

"""Two rooms side by side, with a lamp in each; the camera is in the one with the weak lamp."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Light, LightKind
from gpu.vpl.emitter_importance import IMPORTANCE_PARAMETERS, important_emitters

POWER = np.array([1.0, 30.0, 30.0])


def chosen_in(door: float, cameras: int = 1) -> Doubles:
    """How often each lamp is chosen, the weak one first; door: how much of the wall between the rooms is open."""
    places = (-0.25, 0.2, 0.3)
    lamps = [
        Light(f"lamp {x}", LightKind.POINT, 3 * (power,), position=(x, 0.0, 0.0))
        for x, power in zip(places, POWER.tolist(), strict=True)
    ]
    wall = quad((0.0, -0.5, -0.5), (0.0, 0.0, 1.0 - door), (0.0, 1.0, 0.0))
    inside = look_at((-0.4, 0.0, 0.2), (0.0, 0.0, -0.2))
    scene = replace(scene_of([*box(), wall], [grey(0.6)], lamps), cameras=(inside,) * cameras)
    device_scene = DeviceScene(scene, "cpu")
    table = build_light_table(device_scene)
    cumulative = important_emitters(device_scene, device_scene.data, table).cumulative.numpy()
    return np.diff(cumulative.astype(np.float64), prepend=0.0) / 2.0**32


def test_the_lamp_of_a_closed_room_has_all_but_what_goes_by_power() -> None:
    share = IMPORTANCE_PARAMETERS.power_share
    assert chosen_in(door=0.0) == pytest.approx(share * POWER / POWER.sum() + (1.0 - share) * np.eye(3)[0], abs=1e-3)


def test_lamps_next_door_count_where_their_light_comes_in() -> None:
    weak, *others = chosen_in(door=0.3)
    assert 0.05 < weak < 0.6
    assert sum(others) > 0.4


def test_without_a_camera_power_tells() -> None:
    assert chosen_in(door=0.0, cameras=0) == pytest.approx(POWER / POWER.sum(), abs=1e-6)

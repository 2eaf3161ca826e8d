"""A closed room with a lamp on a wide plain under a sky, and the same with a window."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table, probabilities
from gpu.lights.path_light import by_reach
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Light, LightKind, Scene, Sky
from gpu.vpl.light_reach import light_reach
from gpu.vpl.light_sets import LightSets

CAMERA = look_at((-0.04, 0.0, 0.02), (0.0, 0.0, -0.02))


def room(cameras: tuple[Camera, ...] = (CAMERA,), lamp: float = 5.0, window: float = 0.0) -> DeviceScene:
    """A tenth of the scene's size; window: how much of its front is open."""
    inside = [replace(part, positions=part.positions * 0.1) for part in box(0)[:-1]]
    inside.append(quad((-0.05, -0.05, 0.05), (0.1 * (1.0 - window), 0.0, 0.0), (0.0, 0.1, 0.0), 0))
    light = quad((-0.01, 0.049, -0.01), (0.02, 0.0, 0.0), (0.0, 0.0, 0.02), 1)
    plain = quad((-0.5, -0.06, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), 0)
    made: Scene = scene_of([*inside, light, plain], [grey(0.6), grey(0.0, lamp)])
    return DeviceScene(replace(made, cameras=cameras, sky=Sky((1.0, 1.0, 1.0))), "cpu")


def sky_share(device_scene: DeviceScene) -> tuple[float, float]:
    """How often the sky is chosen of all emitters, by power and as the scene's light sets have it."""
    table = build_light_table(device_scene)
    reached = by_reach(table, light_reach(device_scene, table))
    sky = table.triangle_count
    return float(probabilities(table.all_emitters)[sky]), float(probabilities(reached.all_emitters)[sky])


def test_a_lamp_in_a_closed_room_under_a_sky_is_chosen_more_often_than_by_power() -> None:
    by_power, chosen = sky_share(room())
    assert by_power > 0.99
    assert chosen == pytest.approx(0.3 * by_power, abs=1e-3)
    sets = LightSets(room())
    assert probabilities(sets.table.sampled)[-1] == pytest.approx(0.3 * by_power, abs=1e-3)
    assert probabilities(sets.by_power)[-1] == pytest.approx(by_power, abs=1e-6)


def test_a_sky_counts_by_what_of_it_comes_in() -> None:
    closed, open_to_it = sky_share(room())[1], sky_share(room(window=0.7))[1]
    assert closed + 0.05 < open_to_it < 0.99


def test_power_tells_of_what_is_seen_from_outside() -> None:
    outside = room(cameras=(look_at((0.3, 0.1, 0.3), (0.2, -0.06, 0.2)),))
    assert light_reach(outside, build_light_table(outside)) is None


def test_a_lamp_that_is_off_may_arrive_as_well_as_anything() -> None:
    lit = room().scene
    off = replace(lit.materials[1], emission=(0.0, 0.0, 0.0), stays_light=True)
    bulb = Light("bulb", LightKind.POINT, (0.01, 0.01, 0.01))
    device_scene = DeviceScene(replace(lit, materials=(lit.materials[0], off), lights=(bulb,)), "cpu")
    reach = light_reach(device_scene, build_light_table(device_scene))
    assert reach is not None
    assert reach[0] == reach[2] == reach.max()


@pytest.mark.parametrize("without", ["camera", "sky"])
def test_power_tells_where_there_is_nothing_to_choose_by(without: str) -> None:
    device_scene = room(cameras=()) if without == "camera" else room()
    if without == "sky":
        device_scene = DeviceScene(replace(device_scene.scene, sky=None), "cpu")
    table = build_light_table(device_scene)
    assert light_reach(device_scene, table) is None
    same = probabilities(by_reach(table, None).all_emitters)
    assert np.array_equal(same, probabilities(table.all_emitters))

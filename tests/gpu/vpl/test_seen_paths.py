"""Two rooms side by side with a slit between them; the lamp is in the one and the camera in the other."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_paths import Vpls
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles, Light, LightKind
from gpu.vpl.light_set import LightSetChoice
from gpu.vpl.light_sets import LightSets
from gpu.vpl.seen_paths import MOST_LEFT, SEEN_PARAMETERS, SeenPathEnds, SeenPilot, walked

LAMP = Light("lamp", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.4, 0.2, -0.2))
DARK, BRIGHT = (look_at((x, 0.0, 0.3), (x, 0.0, -0.3)) for x in (-0.1, 0.3))
PATHS, BOUNCES = 4000, 4


def rooms(*cameras: Camera, slit: float = 0.02) -> DeviceScene:
    """The wall between the rooms is at x = 0.1."""
    wall = quad((0.1, -0.5, -0.5), (0.0, 0.0, 1.0 - slit), (0.0, 1.0, 0.0))
    return DeviceScene(replace(scene_of([*box(), wall], [grey(0.7)], [LAMP]), cameras=cameras), "cpu")


def traced(device_scene: DeviceScene, seed: int = 0, *, thins: bool = True) -> tuple[Doubles, Doubles]:
    """Positions (vpl, 3) and flux (vpl,) of what PATHS paths leave."""
    ends = SeenPathEnds(PATHS, BOUNCES, walked(device_scene), thins=thins)
    features = device_scene.generalised().features(lambertian=False)
    ends.trace(device_scene.data, build_light_table(device_scene), wp.array([seed], dtype=int, device="cpu"), features)
    raw: Vpls = ends.raw
    kept = ends.order.numpy()[: ends.count()]
    return raw.position.numpy()[kept].astype(np.float64), raw.flux.numpy()[kept].mean(axis=1).astype(np.float64)


def test_of_what_lights_nothing_that_is_seen_a_tenth_is_left_and_carries_as_much() -> None:
    device_scene = rooms(DARK)
    whole, brought = traced(device_scene, thins=False)
    left, carried = traced(device_scene)
    assert len(left) < 0.3 * len(whole)
    assert carried.sum() == pytest.approx(brought.sum(), rel=0.05)
    in_dark = whole[:, 0] < 0.08
    still = left[:, 0] < 0.08
    assert still.sum() > 0.9 * in_dark.sum() > 0  # where the camera is, all are
    assert carried[still].sum() == pytest.approx(brought[in_dark].sum(), rel=0.05)
    assert carried.max() <= 1.001 * brought.max() / SEEN_PARAMETERS.least


def test_each_seed_leaves_others() -> None:
    device_scene = rooms(DARK)
    one, other = (traced(device_scene, seed)[0] for seed in (1, 2))
    assert len(one) != len(other) or not np.array_equal(one, other)


@pytest.mark.parametrize(("cameras", "thins"), [((DARK,), True), ((BRIGHT,), False), ((), False)])
def test_paths_are_thinned_out_where_few_matter(cameras: tuple[Camera, ...], thins: bool) -> None:
    device_scene = rooms(*cameras)
    features = device_scene.generalised().features(lambertian=False)
    pilot = SeenPilot(BOUNCES, walked(device_scene))
    assert pilot.paths_for(4096, device_scene.data, build_light_table(device_scene), features) > 0
    assert pilot.thins == thins
    assert 0.0 < MOST_LEFT < 1.0


def test_a_light_set_has_as_many_vpls_as_are_wanted_and_more_of_them_where_the_camera_is() -> None:
    inside = []
    for camera in (DARK, BRIGHT):
        light_set = LightSets(rooms(camera)).made(LightSetChoice(4096, 64, BOUNCES, 0, False), lambda *_: None)
        assert light_set.count == pytest.approx(4096, rel=0.15)
        members = light_set.clusters.members
        inside.append(int((members.position.numpy()[: light_set.count, 0] < 0.08).sum()))
    assert inside[0] > 3 * inside[1] > 0

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, resident_of, trace_light_paths, traced_vpls

from gpu.lights.build import build_light_table
from gpu.lights.path_ends import paths_for, pilot_of
from gpu.scene.types import Light, LightKind

BULB = Light("bulb", LightKind.POINT, (1.0, 2.0, 4.0), position=(0.1, 0.0, -0.2))


def test_about_as_many_as_wanted_each_with_flux_and_near_the_next() -> None:
    device_scene = resident_of(box(), [grey(0.7)], lights=[BULB])
    vpls = traced_vpls(device_scene, device_scene.data, 20_000, 4)
    assert vpls.count == pytest.approx(20_000, rel=0.05)
    position, flux = vpls.position.numpy(), vpls.flux.numpy()
    assert (flux.sum(axis=1) > 0.0).all()
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    strides = np.linalg.norm(position[vpls.count // 2 :] - position[: -(vpls.count // 2)], axis=1)
    assert steps.mean() < 0.1 * strides.mean()


def test_no_light_and_black_walls_leave_no_vpl() -> None:
    dark = Light("dark", LightKind.POINT, (0.0, 0.0, 0.0))
    for device_scene in (
        resident_of(box(), [grey(0.7)], lights=[dark]),
        resident_of(box(), [grey(0.0)], lights=[BULB]),
    ):
        assert traced_vpls(device_scene, device_scene.data, 1000, 4).count == 0


def test_a_pilot_run_tells_how_many_paths_are_traced() -> None:
    device_scene = resident_of(box(), [grey(0.7)], lights=[BULB])
    features = device_scene.features(lambertian=False)
    inputs = device_scene, device_scene.data, build_light_table(device_scene), 20_000, 4, features
    for pilot_paths, options in ((4096, {}), (100, {"pilot": pilot_of(4, wp.get_device("cpu"), 100)})):
        found = trace_light_paths(*inputs[:3], pilot_paths, 4, 0).count
        assert paths_for(*inputs, **options) == round(20_000 * pilot_paths / found)


def test_light_that_reaches_nothing_is_not_traced_for_ever() -> None:
    away = Light("away", LightKind.SPOT, (5.0, 5.0, 5.0), (0.0, 0.0, 2.0), (0.0, 0.0, 1.0), 0.99, 0.9)
    device_scene = resident_of(box(), [grey(0.5)], lights=[away])
    features = device_scene.features(lambertian=False)
    inputs = device_scene, device_scene.data, build_light_table(device_scene), 100, 4, features
    assert (paths_for(*inputs), paths_for(*inputs, max_paths_per_vpl=3)) == (1600, 300)

import json
from dataclasses import replace
from math import acos, atan, cos, pi, radians, sin, tan
from pathlib import Path

import numpy as np
import pytest

from gpu.scene.camera import CameraError, look_at, rotated
from gpu.scene.camera_path import CameraPath, monotone_slopes
from gpu.scene.types import Camera

SAMPLES = Path(__file__).parents[2] / "browser" / "unit" / "camera-path.json"
TIMES = (1.0, 2.0, 4.5, 5.0, 8.0)


def gaze(pan: float, tilt: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0), yfov: float = 60.0) -> Camera:
    """A level camera; pan and tilt in degrees."""
    p, t = radians(pan), radians(tilt)
    forward = np.array([-sin(p) * cos(t), sin(t), -cos(p) * cos(t)])
    return look_at(at, (np.array(at) + forward).tolist(), yfov_degrees=yfov)


def walk() -> list[Camera]:
    """Level views around a corner and down some stairs."""
    return [
        gaze(0, 0, (0, 1.6, 0)),
        gaze(-40, -10, (0, 1.6, -4)),
        gaze(170, 20, (3, 1.6, -5), 35),
        gaze(-170, 20, (9, 0, -5), 50),
        gaze(-170, -80, (9, 4, 1)),
    ]


def roll(camera: Camera) -> float:
    """The height that the picture's right has over its left, of 1."""
    return float(camera.to_world[1, 0])


def test_it_passes_through_its_keyframes() -> None:
    cameras = [*walk()[:4], replace(walk()[4], near=0.5)]
    path = CameraPath(TIMES, cameras)
    for time, camera in zip(TIMES, cameras, strict=True):
        found = path.at(time)
        assert np.allclose(found.to_world, camera.to_world, atol=1e-12)
        assert found.half_height == pytest.approx(camera.half_height, rel=1e-12)
        assert found.near == camera.near
    assert np.array_equal(path.at(-5.0).to_world, path.at(1.0).to_world)
    assert np.array_equal(path.at(99.0).to_world, path.at(8.0).to_world)


def test_it_is_smooth() -> None:
    path, step = CameraPath(TIMES, walk()), 1e-5
    for time in TIMES[1:-1]:
        before, now, after = (path.at(time + side * step) for side in (-1, 0, 1))
        speeds = [(now.to_world - before.to_world) / step, (after.to_world - now.to_world) / step]
        assert np.allclose(*speeds, atol=1e-3)
        assert (now.half_height - before.half_height) == pytest.approx(after.half_height - now.half_height, abs=1e-8)
    assert np.linalg.norm(speeds[0]) > 0.1


def test_level_views_stay_level_and_tilts_between_theirs() -> None:
    cameras = walk()
    path = CameraPath(TIMES, cameras)
    for time in np.linspace(1.0, 8.0, 200):
        assert roll(path.at(time)) == pytest.approx(0.0, abs=1e-12)
    pan = CameraPath((0.0, 1.0), (gaze(10, -30), gaze(110, -30)))
    for time in np.linspace(0.0, 1.0, 20):
        forward = -pan.at(time).to_world[:3, 2]
        assert forward[1] == pytest.approx(-0.5)  # the shortest rotation would dip to −42 degrees


def test_it_turns_the_short_way() -> None:
    middle = CameraPath((0.0, 1.0), (gaze(170, 0), gaze(-170, 0))).at(0.5)
    assert np.allclose(middle.to_world, gaze(180, 0).to_world, atol=1e-12)


def test_a_tilted_camera_is_kept_and_levelled_in_between() -> None:
    banked = replace(gaze(30, 10), to_world=gaze(30, 10).to_world @ rolled(20))
    path = CameraPath((0.0, 1.0), (banked, gaze(30, 10)))
    assert np.allclose(path.at(0.0).to_world, banked.to_world, atol=1e-12)
    assert np.allclose(path.at(0.5).to_world, gaze(30, 10).to_world @ rolled(10), atol=1e-12)


def rolled(degrees: float) -> np.ndarray:
    c, s = cos(radians(degrees)), sin(radians(degrees))
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("pan", [0.0, 90.0])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_plan_has_the_heading_of_its_top(pan: float, sign: float) -> None:
    plan = look_at((0, sign * -5, 0), (0, 0, 0))
    if pan:
        plan = replace(plan, to_world=rotated_about_up(pan) @ plan.to_world)
    path = CameraPath((0.0, 1.0), (plan, gaze(pan, 0)))
    assert np.allclose(path.at(0.0).to_world, plan.to_world, atol=1e-9)
    forward = -path.at(0.5).to_world[:3, 2]
    assert forward[1] == pytest.approx(sign * sin(pi / 4), abs=1e-9)
    assert np.linalg.det(path.at(0.3).to_world[:3, :3]) == pytest.approx(1.0)


def rotated_about_up(degrees: float) -> np.ndarray:
    return rotated(gaze(0, 0), degrees).to_world


def test_what_is_constant_stays() -> None:
    still = gaze(25, -15, (1, 2, 3), 45)
    path = CameraPath((0.0, 1.0, 3.0), (still, still, still))
    assert all(np.allclose(path.at(time).to_world, still.to_world, atol=1e-12) for time in np.linspace(0, 3, 13))
    looking = CameraPath((0.0, 1.0, 3.0, 4.0), (gaze(0, 0), still, rotated(still, 0), gaze(0, 0, (9, 9, 9))))
    held = [looking.at(time) for time in (1.0, 1.5, 2.2, 3.0)]
    assert all(np.allclose(camera.to_world, still.to_world, atol=1e-12) for camera in held)
    assert all(camera.half_height == pytest.approx(still.half_height) for camera in held)
    step = 1e-4  # it slows down before it rests, and sets out slowly
    places = [looking.at(time).to_world[:3, 3] for time in (1.0 - step, 1.0, 3.0, 3.0 + step)]
    assert np.linalg.norm(places[1] - places[0]) < 0.01 * step
    assert np.linalg.norm(places[3] - places[2]) < 0.01 * step


@pytest.mark.parametrize("places", [(0, 2, 6), (0, 1, 10), (0, 4, 5, 9, 10), (0, 2)])
def test_a_straight_way_is_straight_and_its_speed_even(places: tuple[float, ...]) -> None:
    """Where the times are as the distances."""
    path = CameraPath(places, [gaze(0, 0, (3 * x, 0, 0)) for x in places])
    found = np.array([path.at(time).to_world[:3, 3] for time in np.linspace(0, places[-1], 201)])
    assert np.allclose(found[:, 1:], 0.0)
    speeds = np.diff(found[:, 0]) / np.diff(np.linspace(0, places[-1], 201))
    assert speeds.min() > 3 * 0.8
    assert speeds.max() < 3 * 1.2


def test_a_round_way_is_round() -> None:
    angles = np.linspace(0.0, 2.0 * pi, 9)
    path = CameraPath(angles.tolist(), [gaze(0, 0, (cos(angle), 0, sin(angle))) for angle in angles])
    found = np.array([path.at(time).to_world[:3, 3] for time in np.linspace(pi / 4, 7 * pi / 4, 100)])
    assert np.allclose(np.linalg.norm(found, axis=1), 1.0, atol=0.02)


def test_the_way_does_not_loop_at_a_sharp_turn() -> None:
    """Two keyframes close together after a far one, where other parameterizations overshoot: it never goes back."""
    places = [(0.0, 0, 0), (10.0, 0, 0), (10.0, 0, 0.5), (0.0, 0, 0.5)]
    path = CameraPath((0.0, 1.0, 2.0, 3.0), [gaze(0, 0, place) for place in places])
    between = np.array([path.at(time).to_world[:3, 3] for time in np.linspace(1.0, 2.0, 50)])
    assert (np.diff(between[:, 2]) > 0.0).all()
    assert between[:, 0].max() < 10.5


def test_a_zoom_is_of_even_ratios() -> None:
    path = CameraPath((0.0, 1.0), (gaze(0, 0, yfov=90.0), gaze(0, 0, yfov=2 * 180 / pi * atan(0.25))))
    assert path.at(0.5).half_height == pytest.approx(0.5)


def test_slopes_are_those_of_scipy() -> None:
    from scipy.interpolate import PchipInterpolator

    rng = np.random.default_rng(4)
    for _ in range(20):
        times, values = np.cumsum(rng.uniform(0.1, 2.0, 7)), np.round(rng.normal(0, 2, 7))
        expected = PchipInterpolator(times, values).derivative()(times)
        assert np.allclose(monotone_slopes(times, values)[1:-1], expected[1:-1], atol=1e-12)


def test_kinds_of_cameras_are_not_mixed() -> None:
    flat = replace(gaze(0, 0), orthographic=True)
    with pytest.raises(CameraError, match=r"keyframes\[1\]\.camera: is orthographic, but the first one is in persp"):
        CameraPath((0.0, 1.0), (gaze(0, 0), flat))
    assert CameraPath((0.0, 1.0), (flat, flat)).at(0.5).orthographic


def test_the_page_flies_the_same_way() -> None:
    """tests/browser/unit/camera-path.test.js holds the page's spline to the same samples."""
    shared = json.loads(SAMPLES.read_text())
    keyframes = shared["keyframes"]
    cameras = [
        replace(gaze(*np.degrees(it["look"]), it["at"], np.degrees(it["yfov"])), near=it.get("near", 0.0))
        for it in keyframes
    ]
    path = CameraPath([it["time"] for it in keyframes], cameras)
    for sample in shared["samples"]:
        found = path.at(sample["time"])
        assert np.allclose(found.to_world[:3, 3], sample["at"], atol=1e-9)
        pan, tilt = sample["look"]
        expected = gaze(*np.degrees((pan, tilt))).to_world[:3, :3]
        assert acos(min(max((np.trace(expected.T @ found.to_world[:3, :3]) - 1) / 2, -1), 1)) < 1e-6
        assert found.half_height == pytest.approx(tan(sample["yfov"] / 2), rel=1e-9)
        assert found.near == pytest.approx(sample["near"], abs=1e-9)

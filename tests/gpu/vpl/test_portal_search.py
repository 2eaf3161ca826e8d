"""Rooms whose light comes in by a slit, by a window, or not at all."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.portals import Portals
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles, Light, LightKind, Sky
from gpu.vpl.portal_search import PortalFinder, Ways, ends_of, first_in_view, free_path, points_on, strip_of
from gpu.vpl.seen_paths import walked

DARK, BRIGHT = (look_at((x, 0.0, 0.3), (x, 0.0, -0.3)) for x in (-0.1, 0.3))


def found(device_scene: DeviceScene) -> "Portals | None":
    return PortalFinder(walked(device_scene)).find(device_scene.data, build_light_table(device_scene))


def rooms(camera: Camera) -> DeviceScene:
    """Two, with a wall at x = 0.1 that has a slit of 4 cm at its end; the lamp is in the one at +X."""
    wall = quad((0.1, -0.5, -0.5), (0.0, 0.0, 0.96), (0.0, 1.0, 0.0))
    lamp = quad((0.2, 0.49, -0.3), (0.2, 0.0, 0.0), (0.0, 0.0, 0.6), 1)
    scene = scene_of([*box(), wall, lamp], [grey(0.7), grey(0.0, 5.0)])
    return DeviceScene(replace(scene, cameras=(camera,)), "cpu")


def under_sky(*lights: Light, sky: Sky | None = None) -> DeviceScene:
    """A room on a wide plain, with a window of 0.2 × 0.2 at +X."""
    hole, side = 0.1, 0.2
    walls = [
        quad((side, -side, -side), (0.0, side - hole, 0.0), (0.0, 0.0, 2.0 * side)),
        quad((side, hole, -side), (0.0, side - hole, 0.0), (0.0, 0.0, 2.0 * side)),
        quad((side, -hole, -side), (0.0, 2.0 * hole, 0.0), (0.0, 0.0, side - hole)),
        quad((side, -hole, hole), (0.0, 2.0 * hole, 0.0), (0.0, 0.0, side - hole)),
    ]
    plain = quad((-2.0, -0.25, 2.0), (4.0, 0.0, 0.0), (0.0, 0.0, -4.0))
    parts = [part for part in box(half=side) if not np.all(part.positions[:, 0] == side)]
    scene = scene_of([*parts, *walls, plain], [grey(0.6)], lights, sky=sky)
    return DeviceScene(replace(scene, cameras=(look_at((-0.15, 0.0, 0.0), (0.2, -0.1, 0.0)),)), "cpu")


def places(device_scene: DeviceScene, portals: "Portals | None") -> tuple[Doubles, Doubles]:
    """Centres [m] and axes of portals, (portal, 3) each."""
    assert portals is not None
    count = int(portals.count.numpy()[0])
    strips, placement = portals.strips.numpy()[:count], device_scene.scene.placement
    assert strips["chance"].sum() == pytest.approx(1.0)
    return strips["centre"] / placement.scale + np.array(placement.centre), strips["axis"].astype(np.float64)


def test_a_slit_that_all_light_comes_by_is_found_and_no_wider_than_it_is() -> None:
    device_scene = rooms(DARK)
    portals = found(device_scene)
    centres, axes = places(device_scene, portals)
    assert len(centres) > 0
    assert np.abs(centres[:, 0] - 0.1).max() < 0.05
    assert np.abs(centres[:, 2] - 0.48).max() < 0.03
    assert (axes[:, 0] < -0.3).all()
    strips = portals.strips.numpy()[: len(centres)]  # type: ignore[union-attr]
    assert np.abs(strips["half"][:, 1]).max() > 3 * strips["narrow"].max()


def test_what_is_lit_by_a_lamp_in_view_has_none() -> None:
    assert found(rooms(BRIGHT)) is None


def test_a_sky_comes_by_the_window_and_its_ways_begin_outside() -> None:
    device_scene = under_sky(sky=Sky((1.0, 1.0, 1.0)))
    centres, axes = places(device_scene, found(device_scene))
    assert (np.abs(centres[:, 0] - 0.25) < 0.15).all()
    assert np.median(np.abs(centres[:, 1:])) < 0.1
    assert (axes[:, 0] < 0.0).all()


def test_a_sun_whose_paths_have_a_map_has_none_of_its_own() -> None:
    low = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(-1.0, -0.001, 0.0))
    assert found(under_sky(low)) is None


def test_a_block_under_a_sky_has_none() -> None:
    """Of its surface nothing sees anything else, so there is no length to measure by."""
    sides = [replace(part, triangles=part.triangles[:, ::-1]) for part in box()]
    scene = scene_of(sides, [grey(0.6)], sky=Sky((1.0, 1.0, 1.0)))
    block = DeviceScene(replace(scene, cameras=(look_at((1.2, 1.0, 1.3), (0.0, 0.0, 0.0)),)), "cpu")
    assert free_path(walked(block).numpy()) == 0.0
    assert found(block) is None


def test_without_a_camera_there_are_none() -> None:
    assert found(DeviceScene(replace(rooms(DARK).scene, cameras=()), "cpu")) is None


def test_the_same_light_has_the_same_portals() -> None:
    one, other = (places(device_scene, found(device_scene)) for device_scene in (rooms(DARK), rooms(DARK)))
    assert np.array_equal(one[0], other[0])


def test_points_lie_in_the_order_of_light_on_each_way() -> None:
    corners = np.array([[[0, 0, 0], [1, 0, 0], [1, 2, 0]], [[0, 0, 1], [0, 0, 2], [9, 9, 9]]], np.float32)
    points = points_on(Ways(corners, np.array([3, 2], np.int32)), 0.5, 3)
    assert points.way.tolist() == [0] * 5 + [1] * 2
    assert points.place[:3] == pytest.approx(np.array([[1.0, 1.25, 0.0], [1.0, 0.75, 0.0], [1.0, 0.25, 0.0]]))
    assert points.place[3:5, 0] == pytest.approx([0.75, 0.25])
    assert points.along[0] == pytest.approx([0.0, -1.0, 0.0])
    assert points.along[3] == pytest.approx([-1.0, 0.0, 0.0])
    assert points.place[5:, 2] == pytest.approx([1.75, 1.25])


def test_ends_of_ways_are_beside_the_light_and_beside_what_it_lights() -> None:
    corners = np.array([[[0, 0, 0], [1, 0, 0], [1, 2, 0]], [[0, 0, 1], [0, 0, 9], [9, 9, 9]]], np.float32)
    begins, ends = ends_of(Ways(corners, np.array([3, 2], np.int32)), 0.5, 8)
    assert begins == pytest.approx(np.array([[1.0, 1.75, 0.0], [0.0, 0.0, 4.75]]))
    assert ends == pytest.approx(np.array([[0.25, 0.0, 0.0], [0.0, 0.0, 1.25]]))


def test_the_free_path_is_that_between_first_vertices() -> None:
    walks = walked(rooms(DARK)).numpy()
    assert 0.2 < free_path(walks) < 0.8
    assert free_path(np.zeros_like(walks)) == 0.0


def test_a_way_comes_into_view_once_and_not_where_it_begins() -> None:
    way = np.array([0, 0, 0, 0, 1, 1, 2, 2, 2], np.int32)
    seen = np.array([0, 1, 0, 1, 1, 1, 0, 0, 1], bool)
    assert first_in_view(way, seen).tolist() == [1, 8]
    assert first_in_view(way[:0], seen[:0]).tolist() == []


def test_a_strip_spans_what_it_is_for() -> None:
    x, z = np.meshgrid(np.linspace(-0.01, 0.01, 21), np.linspace(-0.3, 0.3, 21))
    place = np.stack([x.ravel(), np.full(x.size, 0.5), z.ravel()], axis=1).astype(np.float32)
    along = np.tile(np.array([0.0, -1.0, 0.0], np.float32), (x.size, 1))
    centre, axis, half, narrow, width, ways = strip_of(place, along, 0.0)
    assert centre == pytest.approx([0.0, 0.5, 0.0], abs=1e-6)
    assert axis == pytest.approx([0.0, -1.0, 0.0])
    assert np.abs(half) == pytest.approx([0.0, 0.0, 0.3], rel=0.06, abs=1e-6)
    assert (narrow, width) == pytest.approx((0.01, 0.01), rel=0.06)
    assert ways == x.size
    wider = strip_of(place, along, 0.1)
    assert (wider[3], wider[4]) == pytest.approx((narrow + 0.01, width + 0.1))

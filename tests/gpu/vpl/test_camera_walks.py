"""A room that is closed, and one without its front."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.scene.camera import look_at
from gpu.vpl.camera_walks import walk_from_cameras

HALF, WALKS, LENGTH = 0.5, 512, 3


def walked(front: bool) -> tuple[np.ndarray, np.ndarray]:
    """Where walks came, in units of the box, and the normals there, both (walk, vertex, 3)."""
    walls = [part for part in box(half=HALF) if front or not (part.positions[:, 2] == HALF).all()]
    inside = look_at((0.0, 0.0, 0.3), (0.0, 0.0, -0.5))
    device_scene = DeviceScene(replace(scene_of(walls, [grey(0.5)], []), cameras=(inside, inside)), "cpu")
    vertices = walk_from_cameras(device_scene, device_scene.data, WALKS, LENGTH).numpy()
    placement = device_scene.scene.placement
    return vertices["position"] / placement.scale + np.asarray(placement.centre), vertices["normal"]


def test_in_a_closed_room_walks_go_from_wall_to_wall_and_begin_where_cameras_look() -> None:
    position, normal = walked(front=True)
    assert np.abs(position).max(axis=2) == pytest.approx(HALF, abs=1e-4)
    assert (position * normal).sum(axis=2) == pytest.approx(-HALF, abs=1e-4)
    assert position[:, 0, 2].max() < 0.3
    assert position[:, 1:, 2].max() == pytest.approx(HALF, abs=1e-4)


def test_walks_end_where_they_leave_the_room() -> None:
    _, normal = walked(front=False)
    length = np.linalg.norm(normal, axis=2)
    assert np.isin(length.round(4), (0.0, 1.0)).all()
    going = (length > 0.0).mean(axis=0)
    assert going[0] == 1.0
    assert 0.9 > going[1] > going[2] > 0.3
    assert (np.diff(length, axis=1) <= 1e-4).all()


@pytest.mark.parametrize(("through", "least", "most"), [(0.0, 0.0, 0.0), (0.5, 0.4, 0.6), (1.0, 1.0, 1.0)])
def test_walks_go_through_what_is_translucent(through: float, least: float, most: float) -> None:
    paper = replace(grey(0.8), specular=0.0, diffuse_transmission=through, diffuse_transmission_color=(0.8, 0.8, 0.8))
    inside = look_at((0.0, 0.0, 0.3), (0.0, 0.0, -0.5))
    device_scene = DeviceScene(replace(scene_of(box(half=HALF), [paper]), cameras=(inside,)), "cpu")
    first = walk_from_cameras(device_scene, device_scene.data, WALKS, 1).numpy()[:, 0]
    outwards = (first["position"] * first["normal"]).sum(axis=1) > 0.0
    assert least <= outwards.mean() <= most


@pytest.mark.parametrize(("roughness", "transmission"), [(0.4, 1.0), (0.4, 0.6)])
def test_walks_go_through_frosted_glass(roughness: float, transmission: float) -> None:
    pane = replace(grey(0.8), roughness=roughness, transmission=transmission, double_sided=True)
    inside = look_at((0.0, 0.0, 0.3), (0.0, 0.0, -0.5))
    device_scene = DeviceScene(replace(scene_of(box(half=HALF), [pane]), cameras=(inside,)), "cpu")
    first = walk_from_cameras(device_scene, device_scene.data, WALKS, 1).numpy()[:, 0]
    outwards = (first["position"] * first["normal"]).sum(axis=1) > 0.0
    assert outwards.mean() == pytest.approx(transmission, abs=0.02)

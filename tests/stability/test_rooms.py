"""A thin wall between two rooms, only one of which is lit, keeps the other dark, and walls keep the sun out."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, resident_of, scene_of
from stress import render

from gpu.device_scene.upload import DeviceScene
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Light, LightKind
from gpu.settings import Method

SIZE = (64, 32)
WALL = 0.01
INSIDE = look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0))
LEAK = 1e-3  # of a lit room's light, that a dark one beside it may have


def slab(low: tuple[float, float, float], high: tuple[float, float, float], *, inside: bool) -> list[MeshPart]:
    """A box of any size whose fronts are inside or outside, the floor and ceiling last."""
    parts = []
    for axis in (0, 2, 1):
        for side in (0, 1):
            corner, u, v = np.array(low), np.zeros(3), np.zeros(3)
            corner[axis] = (low, high)[side][axis]
            u[(axis + 1) % 3], v[(axis + 2) % 3] = (np.array(high) - low)[[(axis + 1) % 3, (axis + 2) % 3]]
            parts.append(quad(corner, u, v) if (side == 0) == inside else quad(corner, v, u))
    return parts


def rooms(device: str, *, closed: bool) -> DeviceScene:
    """Two rooms of 4 × 3 × 4 metres, a wall of a centimetre between them, a lamp in the one at x < 0."""
    parts = slab((-4.0, 0.0, -2.0), (4.0, 3.0, 2.0), inside=True)
    parts = parts if closed else parts[:-1]
    wall = slab((-WALL / 2.0, 0.0, -2.0), (WALL / 2.0, 3.0, 2.0), inside=False)
    lamp = quad((-2.5, 2.5, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1)
    return resident_of([*parts, *wall, lamp], [grey(0.7), grey(0.0, 10.0)], device=device)


@pytest.mark.parametrize("method", list(Method))
def test_seen_from_inside(device: str, method: Method) -> None:
    device_scene = rooms(device, closed=True)
    cameras = [look_at((side * 3.8, 1.5, 0.3), (0.0, 1.2, 0.0), yfov_degrees=80.0) for side in (-1.0, 1.0)]
    lit, dark = (render(device_scene, camera, SIZE, method=method, samples=4).mean() for camera in cameras)
    assert lit > 0.1
    assert dark < LEAK * lit


# Fuzzy visibility gives the floor at the wall's foot some of what the floor behind the wall sees: they have one plane
# and one normal. Rays of their own mend that as far as they reach, which is not all where clusters are few (one for 70
# pixels).
@pytest.mark.parametrize(("sp_clusters", "share"), [(200, 1e-3), (30, 2e-2)])
@pytest.mark.parametrize("method", list(Method))
def test_seen_both_at_once_from_above(device: str, method: Method, sp_clusters: int, share: float) -> None:
    """Without a ceiling, so that shading points on both sides of the wall may share clusters."""
    above = look_at((0.0, 9.0, 0.0), (0.0, 0.0, 0.0), yfov_degrees=36.0)
    device_scene = rooms(device, closed=False)
    picture = render(device_scene, above, SIZE, method=method, samples=4, sp_clusters=sp_clusters)
    lit, dark = picture[:, : SIZE[0] // 2 - 1].mean(), picture[:, SIZE[0] // 2 + 1 :].mean()
    assert lit > 0.1
    assert dark < (share if method in (Method.FUZZY_VPL, Method.RSM_DISKS) else LEAK) * lit


def closed_room(device: str, sun: float) -> DeviceScene:
    """A cube on a wide ground with a lamp inside, which the scene's cameras see, and above a sun of this irradiance."""
    ground = quad((-4.0, -0.6, 4.0), (8.0, 0.0, 0.0), (0.0, 0.0, -8.0))
    lamp = Light("lamp", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.0, 0.0, 0.0))
    shining = Light("sun", LightKind.DIRECTIONAL, (sun, sun, sun), direction=(0.0, -0.8, 0.6))
    scene = scene_of([*box(half=0.5), ground], [grey(0.5)], [shining, lamp] if sun else [lamp])
    return DeviceScene(replace(scene, cameras=(INSIDE,)), device)


@pytest.mark.parametrize("method", list(Method))
def test_a_sun_outside_a_closed_room_does_nothing_inside(device: str, method: Method) -> None:
    """Neither a pixel where walls meet is lit by it, nor does it take what the lamp has: light paths, clusters, rays.

    Pictures of both are of other light paths, so they differ by noise.
    """
    pictures = (render(closed_room(device, sun), INSIDE, (128, 96), method=method, samples=16) for sun in (0.0, 1e5))
    alone, beside = (picture.mean(axis=-1) for picture in pictures)
    assert beside.mean() == pytest.approx(alone.mean(), rel=0.02)
    assert np.abs(beside / alone - 1.0).max() < 0.6

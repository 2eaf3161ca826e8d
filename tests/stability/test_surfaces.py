"""Sides and alpha of surfaces mean the same to every method: each pair of rooms must look the same."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of
from stress import render

from gpu.device_scene.upload import DeviceScene
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import AlphaMode, Camera, Doubles, Material, Texture, TextureSlot
from gpu.settings import Method

SIZE = (24, 18)
CAMERA = look_at((0.2, 0.1, 0.3), (-0.3, -0.2, -0.4), yfov_degrees=80.0)
FROM_OUTSIDE = look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), yfov_degrees=25.0)
UP, DOWN = ([0.0, 0.0, 0.4], [0.4, 0.0, 0.0]), ([0.4, 0.0, 0.0], [0.0, 0.0, 0.4])
LAMP = grey(0.0, 3.0)


def picture(parts: Sequence[MeshPart], materials: Sequence[Material], method: Method, device: str,
            textures: Sequence[Texture] = (), camera: Camera = CAMERA) -> Doubles:  # fmt: skip
    device_scene = DeviceScene(scene_of(parts, materials, textures=textures), device)
    if textures:  # in one scene alone: general kernels are compiled for others in any case
        device_scene = device_scene.generalised()
    return np.asarray(render(device_scene, camera, SIZE, method=method, samples=8, vpls=3000, seed=3))


@pytest.mark.parametrize("method", list(Method))
def test_a_two_sided_lamp_is_two_lamps_back_to_back(device: str, method: Method) -> None:
    place = [-0.2, 0.1, -0.2]
    both = [*box(), quad(place, *UP, 1)]
    two = [*both, quad(place, *DOWN, 1)]
    found = picture(both, [grey(0.5), replace(LAMP, double_sided=True)], method, device)
    wanted = picture(two, [grey(0.5), replace(LAMP, double_sided=False)], method, device)
    assert found.mean() == pytest.approx(wanted.mean(), rel=0.02)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.PATH])
def test_a_masked_lamp_is_the_part_that_is_left(device: str, method: Method) -> None:
    pixels = np.full((1, 8, 4), 255, np.uint8)
    pixels[:, :4, 3] = 0
    sign = replace(LAMP, alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0))
    textures = [Texture("half", pixels, srgb=True, nearest=True)]
    found = picture([*box(), quad([-0.2, 0.1, -0.2], *DOWN, 1)], [grey(0.5), sign], method, device, textures)
    left = quad([0.0, 0.1, -0.2], [0.2, 0.0, 0.0], [0.0, 0.0, 0.4], 1)
    wanted = picture([*box(), left], [grey(0.5), LAMP], method, device)
    assert found.mean() == pytest.approx(wanted.mean(), rel=0.03)


@pytest.mark.parametrize("method", list(Method))
def test_a_wall_of_two_skins_reflects_the_colour_of_each_side(device: str, method: Method) -> None:
    """A room is divided by a wall that is red on this side and black on the other, where there is no light."""
    red = replace(grey(0.5), base_color=(0.8, 0.0, 0.0, 1.0), double_sided=False)
    materials = [replace(grey(0.5), double_sided=False), LAMP, red, replace(grey(0.0), double_sided=False)]
    wall = quad([-0.3, -0.5, -0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 2)  # faces +x
    lamp = quad([-0.1, 0.4, -0.2], *DOWN, 1)
    alone = picture([*box(), wall, lamp], materials, method, device)
    skins = [quad([-0.3, -0.5, -0.5], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], 3), wall]
    found = picture([*box(), *skins, lamp], materials, method, device)
    assert found.mean(axis=(0, 1)) == pytest.approx(alone.mean(axis=(0, 1)), rel=0.02)


@pytest.mark.parametrize("method", list(Method))
def test_a_room_seen_from_outside_is_lit_as_from_inside(device: str, method: Method) -> None:
    """A closed grey room whose walls emit: radiance Le / (1 − ρ) all over, seen through the backs of its walls."""
    walls = replace(grey(0.5, 1.0), double_sided=False)
    found = picture(box(), [walls], method, device, camera=FROM_OUTSIDE)[5:13, 8:16]
    # Of four bounces 1.94, of one 1.75.
    assert found.mean() == pytest.approx(1.75 if method is Method.RSM_DISKS else 2.0, rel=0.1)

"""A scene without light gets one that reaches what its camera sees."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad

from gpu.scene.assemble import assemble
from gpu.scene.camera import look_at
from gpu.scene.lighting.default_light import SOFT_SKY
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import AlphaMode, Camera, Light, LightKind, Material, Scene, Texture, TextureSlot

INSIDE = look_at((0.2, 0.1, 0.3), (-0.3, -0.2, -0.4), yfov_degrees=80.0, name="inside")
OUTSIDE = look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), yfov_degrees=25.0, name="outside")
WHITE = Material(base_color=(0.8, 0.8, 0.8, 1.0), double_sided=False)


def room(camera: Camera, walls: Material = WHITE, **found: object) -> Scene:
    return assemble("room", SceneParts(box(), [walls], cameras=[camera], **found))


@pytest.mark.parametrize("camera", [INSIDE, OUTSIDE, replace(OUTSIDE, orthographic=True, half_height=0.4)])
def test_a_closed_room_gets_a_lamp_that_is_in_it(camera: Camera) -> None:
    scene = room(camera)
    (lamp,) = scene.lights
    assert scene.sky is None
    assert lamp.kind is LightKind.POINT
    assert (np.abs(lamp.position) < 0.5).all()
    assert "no sky would reach what its camera sees: a lamp was added at" in scene.report.notes[-1]


def test_the_lamp_is_not_beside_the_wall_that_the_camera_is_at() -> None:
    (lamp,) = room(look_at((0.0, 0.0, 0.49), (0.0, 0.0, 0.0), yfov_degrees=80.0)).lights
    assert (np.abs(lamp.position) < 0.4).all()


def test_a_room_that_is_open_gets_a_sky() -> None:
    scene = assemble("room", SceneParts(box()[:-1], [WHITE], cameras=[INSIDE]))
    assert (scene.sky, scene.lights) == (SOFT_SKY, ())
    assert scene.report.notes == ("the scene has no light: a soft sky from above was added",)


def test_what_is_seen_from_outside_gets_a_sky() -> None:
    assert room(OUTSIDE, replace(WHITE, double_sided=True)).sky == SOFT_SKY


def test_nothing_in_view_gets_a_sky() -> None:
    assert room(look_at((0.0, 0.0, 2.0), (0.0, 0.0, 5.0), yfov_degrees=25.0)).sky == SOFT_SKY


def test_a_section_shows_what_it_cuts_open() -> None:
    cut = replace(OUTSIDE, near=1.6)
    scene = room(cut, replace(WHITE, double_sided=True))
    assert len(scene.lights) == 1


VEIL, PANE = Material(alpha_mode=AlphaMode.BLEND), Material(transmission=1.0, roughness=0.0)


@pytest.mark.parametrize(
    ("glass", "lit"),
    [
        (replace(VEIL, base_color=(1.0, 1.0, 1.0, 0.2)), True),
        (replace(VEIL, base_color=(1.0, 1.0, 1.0, 0.9)), False),
        (PANE, True),
        (replace(PANE, thickness=1.0), True),
        (replace(PANE, roughness=0.2), False),
    ],
)
def test_clear_glass_lets_the_sky_in(glass: Material, lit: bool) -> None:
    """One wall of a room is a pane."""
    walls = box()
    walls[-1] = replace(walls[-1], material=1)
    scene = assemble("room", SceneParts(walls, [WHITE, glass], cameras=[INSIDE]))
    assert (scene.sky is not None) == lit


@pytest.mark.parametrize(
    "lamp",
    [
        replace(grey(0.0, 3.0), unlit=True),
        replace(grey(0.0, 3.0), alpha_mode=AlphaMode.BLEND, base_color=(1.0, 1.0, 1.0, 0.0)),
        replace(grey(0.0, 3.0), alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0)),
    ],
)
def test_lamps_that_give_no_light_are_none(lamp: Material) -> None:
    clear = Texture("clear", np.zeros((1, 1, 4), np.uint8), srgb=True)
    parts = [*box(), quad([-0.2, 0.1, -0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4], 1)]
    scene = assemble("room", SceneParts(parts, [WHITE, lamp], [clear], cameras=[INSIDE]))
    assert any("the scene has no light" in note for note in scene.report.notes)


def test_lamps_that_are_switched_off_are_meant_to_be() -> None:
    off = Light("off", LightKind.POINT, (0.0, 0.0, 0.0))
    scene = room(INSIDE, lights=[off])
    assert scene.lights == (off,)
    assert "switched off" in scene.report.notes[-1]
    assert not room(INSIDE, lights=[off, replace(off, intensity=(0.0, 0.0, 1.0))]).report.notes

"""Whose lamps are shut in, and what a view that was chosen shows of such a scene."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad

from gpu.scene.assemble import assemble
from gpu.scene.camera import look_at
from gpu.scene.lighting.shut_in import is_shut_in
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import AlphaMode, Light, LightKind, Material, Scene, Sky

LAMP = quad([-0.1, 0.4, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
BULB = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0))
SUN = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
INSIDE = look_at((0.2, 0.1, 0.3), (-0.3, -0.2, -0.4))


def cube(*, outwards: bool = True) -> list[MeshPart]:
    return [replace(part, triangles=part.triangles[:, ::-1]) if outwards else part for part in box()]


def scene_of(walls: list[MeshPart], glow: float = 1.0, wall: Material | None = None, **found: object) -> Scene:
    return assemble("cube", SceneParts([*walls, LAMP], [wall or grey(0.5), grey(0.5, glow)], **found))


@pytest.mark.parametrize(("lamps", "glow"), [([], 1.0), ([BULB], 0.0)])
def test_a_closed_room_shuts_its_lamps_in_and_an_open_one_does_not(lamps: list[Light], glow: float) -> None:
    assert is_shut_in(scene_of(cube(), glow, lights=lamps, cameras=[INSIDE]))
    assert not is_shut_in(scene_of(cube()[1:], glow, lights=lamps, cameras=[INSIDE]))


@pytest.mark.parametrize("found", [{"lights": [SUN]}, {"lights": [BULB, SUN]}, {"sky": Sky((1.0, 1.0, 1.0))}])
def test_a_sun_and_a_sky_are_outside(found: dict[str, object]) -> None:
    assert not is_shut_in(scene_of(cube(), **found))


@pytest.mark.parametrize(
    "glass",
    [
        Material(transmission=1.0, roughness=0.0),
        Material(base_color=(1.0, 1.0, 1.0, 0.2), alpha_mode=AlphaMode.BLEND),
    ],
)
def test_glass_shuts_nothing_in(glass: Material) -> None:
    assert not is_shut_in(scene_of(cube(), wall=glass))


def test_without_lamps_nothing_is_shut_in() -> None:
    dark = replace(BULB, intensity=(0.0, 0.0, 0.0))
    assert not is_shut_in(scene_of(cube(), 0.0, lights=[dark], cameras=[INSIDE]))


def from_within(scene: Scene) -> bool:
    return bool((np.abs(scene.cameras[0].to_world[:3, 3]) < 0.5).all())


def test_a_cube_that_is_a_room_is_seen_from_within_as_all_else_of_it_is_dark() -> None:
    assert from_within(scene_of(cube(outwards=False)))
    assert from_within(scene_of(cube()))
    assert not from_within(scene_of(cube(), lights=[SUN]))
    assert not from_within(scene_of(cube()[1:]))


def test_a_view_of_the_file_stays() -> None:
    outside = look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    assert not from_within(scene_of(cube(), cameras=[outside]))

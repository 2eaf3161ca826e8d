from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene import validate
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import Camera, Light, LightKind, Material, Texture, TextureSlot

LIGHT = Light("l", LightKind.SPOT, (1.0, 1.0, 1.0))
CAMERA = Camera("c", np.eye(4), 1.0)
TEXTURE = Texture("t", np.zeros((2, 3, 4), np.uint8), srgb=True)


@pytest.mark.parametrize(
    ("material", "says"),
    [
        (Material(roughness=nan), "materials[0].roughness[0]: is not finite"),
        (Material(emission=(1.0, inf, 0.0)), "materials[0].emission[1]: is not finite"),
        (Material(base_color=(1.0, -1.0, 0.0, 1.0)), "materials[0].base_color: must not be negative"),
        (Material(normal_slot=TextureSlot(1)), "materials[0].normal_slot.texture[0]: index out of range"),
        (Material(normal_slot=TextureSlot(0, uv_set=8)), "materials[0].normal_slot.uv_set"),
        (Material(normal_slot=TextureSlot(0, 0, (nan, 0.0, 0.0, 0.0, 1.0, 0.0))), "normal_slot.transform"),
    ],
)
def test_materials(material: Material, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        validate.check_materials("scene", [material], 1, DEFAULT_LIMITS)
    assert says in str(caught.value)


def test_sound_materials() -> None:
    validate.check_materials("scene", [Material(normal_slot=TextureSlot(0), normal_scale=-1.0)], 1, DEFAULT_LIMITS)
    with pytest.raises(SceneError, match=r"2 materials, more than the 1 allowed; .*max_materials"):
        validate.check_materials("scene", [Material()] * 2, 0, SceneLimits(max_materials=1))


@pytest.mark.parametrize(
    "change",
    [
        {"intensity": (nan, 1.0, 1.0)},
        {"intensity": (-1.0, 1.0, 1.0)},
        {"position": (inf, 0.0, 0.0)},
        {"direction": (0.0, 0.0, 2.0)},
        {"cos_inner": 0.1, "cos_outer": 0.2},
        {"cos_inner": nan},
    ],
)
def test_lights(change: dict) -> None:
    validate.check_lights("scene", [LIGHT], DEFAULT_LIMITS)
    with pytest.raises(SceneError, match=r"lights\[1\]"):
        validate.check_lights("scene", [LIGHT, replace(LIGHT, **change)], DEFAULT_LIMITS)


@pytest.mark.parametrize(
    "change", [{"half_height": 0.0}, {"half_height": nan}, {"aspect": -1.0}, {"to_world": np.full((4, 4), nan)}]
)
def test_cameras(change: dict) -> None:
    validate.check_cameras("scene", [CAMERA], DEFAULT_LIMITS)
    with pytest.raises(SceneError, match=r"cameras\[0\]"):
        validate.check_cameras("scene", [replace(CAMERA, **change)], DEFAULT_LIMITS)


@pytest.mark.parametrize(
    ("pixels", "limits"),
    [
        (np.zeros((2, 3, 3), np.uint8), DEFAULT_LIMITS),
        (np.zeros((0, 3, 4), np.uint8), DEFAULT_LIMITS),
        (np.zeros((2, 3, 4), np.float32), DEFAULT_LIMITS),
        (TEXTURE.pixels, SceneLimits(max_texture_size=2)),
        (TEXTURE.pixels, SceneLimits(max_texture_pixels=5)),
    ],
)
def test_textures(pixels: np.ndarray, limits: SceneLimits) -> None:
    validate.check_textures("scene", [TEXTURE, replace(TEXTURE, srgb=False)], SceneLimits(max_texture_pixels=6))
    with pytest.raises(SceneError, match="scene"):
        validate.check_textures("scene", [replace(TEXTURE, pixels=pixels)], limits)


def test_as_many_lights_cameras_and_uv_sets_as_may_be_and_no_more() -> None:
    limits = SceneLimits(max_lights=2, max_cameras=2, max_uv_sets=2)
    validate.check_lights("scene", [LIGHT] * 2, limits)
    validate.check_cameras("scene", [CAMERA] * 2, limits)
    validate.check_materials("scene", [Material(normal_slot=TextureSlot(0, uv_set=1))], 1, limits)
    with pytest.raises(SceneError, match=r"3 lights, more than the 2 allowed; .*max_lights"):
        validate.check_lights("scene", [LIGHT] * 3, limits)
    with pytest.raises(SceneError, match=r"3 cameras, more than the 2 allowed; .*max_cameras"):
        validate.check_cameras("scene", [CAMERA] * 3, limits)
    with pytest.raises(SceneError, match=r"normal_slot\.uv_set"):
        validate.check_materials("scene", [Material(normal_slot=TextureSlot(0, uv_set=2))], 1, limits)

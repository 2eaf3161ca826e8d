from dataclasses import replace

import numpy as np
from scenes import box, quad, resident_of, scene_of

from gpu.device_scene.material_rows import material_rows
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import Material, Texture, TextureSlot


def test_rows_of_known_materials_are_those_made_anew() -> None:
    known = (Material(), Material(base_color_slot=TextureSlot(0), roughness=0.5), Material(metallic=1.0))
    changed = (known[0], replace(known[1], roughness=0.25), known[2])
    rows = material_rows(changed, 2.0, (known, material_rows(known, 2.0)))
    assert np.array_equal(rows, material_rows(changed, 2.0))
    assert rows["slots"].tolist() == [0, 1, 0]


def test_absorption_follows_the_colour_and_the_unit_of_the_file() -> None:
    material = Material(thickness=1.0, attenuation_color=(0.5, 1.0, 0.0), attenuation_distance=0.5)
    placed = scene_of([quad([0, 0, 0], [4, 0, 0], [0, 2, 0])], [material])
    assert placed.placement.scale == 0.25
    for metres in (1.0, 0.01):
        scene = replace(placed, frame=replace(placed.frame, metres_per_unit=metres))
        found = DeviceScene(scene, "cpu").data.materials.numpy()["absorption"][0]
        expected = -np.log([0.5, 1.0, 1e-6]) / (0.5 * metres * 0.25)
        assert np.allclose(found, expected, rtol=1e-5)
    assert not DeviceScene(scene_of(box(), [Material()]), "cpu").data.materials.numpy()["absorption"].any()


def test_an_image_of_several_textures_is_stored_once() -> None:
    pixels, other = np.zeros((4, 8, 4), np.uint8), np.ones((2, 2, 4), np.uint8)
    textures = [
        Texture("one", pixels, srgb=True),
        Texture("same", pixels, srgb=False),
        Texture("other", other, srgb=True),
    ]
    materials = [Material(base_color_slot=TextureSlot(number)) for number in range(3)]
    data = resident_of([quad([0, 0, 0], [1, 0, 0], [0, 1, 0], number) for number in range(3)], materials,
                       textures=textures).data  # fmt: skip
    entries = data.textures.numpy()
    assert entries["first"].tolist() == [0, 0, 32]
    assert entries["width"].tolist() == [8, 8, 2]
    assert entries["srgb"].tolist() == [True, False, True]
    assert len(data.texels) == 36

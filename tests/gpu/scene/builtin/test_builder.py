"""A builder keeps shapes with their materials, places them, and calls materials by name."""

from functools import partial
from threading import Barrier

import numpy as np
import pytest

from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.shapes import block
from gpu.scene.camera import look_at
from gpu.scene.types import Bytes, Doubles, Scene

CUBE = block((0, 0, 0), (1, 1, 1))
VIEW = [look_at((0, 0, 9), (0, 0, 0))]


def corners(scene: Scene, material: int) -> tuple[Doubles, Doubles]:
    """The lowest and highest corner of a material's triangles, in metres."""
    used = scene.vertices[scene.triangles[scene.triangle_material == material]].reshape(-1, 3)
    world = used / scene.placement.scale + scene.placement.centre
    return world.min(axis=0), world.max(axis=0)


def test_shapes_get_the_materials_named_and_the_places_of_their_frame() -> None:
    builder = Builder("cubes")
    builder.paints("grey #808080 0.6")
    builder.light("glow", (1.0, 2.0, 3.0))
    builder.add("grey", [CUBE, CUBE.moved(1.0)])
    builder.frame(90.0, (0.0, 5.0, 0.0)).add("grey, glow", (CUBE, CUBE), [(2.0, 0.0, 0.0), (4.0, 0.0, 0.0)])
    scene = builder.scene(VIEW)
    np.testing.assert_allclose(corners(scene, 0), [(0, 0, -5), (2, 6, 1)], atol=1e-5)
    np.testing.assert_allclose(corners(scene, 1), [(0, 5, -5), (1, 6, -2)], atol=1e-5)
    assert scene.materials[1].emission == (1.0, 2.0, 3.0)
    assert len(scene.triangles) == 12 * 6


def test_a_name_means_the_last_material_made_with_it() -> None:
    builder = Builder("paintings")
    for level in (100, 200):
        builder.textured("painting", partial(np.full, (4, 4, 4), level, np.uint8), (2.0, 0.5))
        builder.add("painting", CUBE)
    scene = builder.scene(VIEW)
    assert np.bincount(scene.triangle_material).tolist() == [12, 12]
    slot = scene.materials[1].base_color_slot
    assert slot is not None
    assert scene.textures[slot.texture].pixels[0, 0, 0] == 200
    assert slot.transform == (0.5, 0.0, 0.0, 0.0, 2.0, 0.0)


def test_images_are_made_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu.scene.builtin.builder.IMAGES_AT_ONCE", 2)
    both, builder = Barrier(2), Builder("images")

    def image(level: int) -> Bytes:
        both.wait(60.0)  # for the other one
        return np.full((4, 4, 4), level, np.uint8)

    for level in (100, 200):
        builder.textured(f"painting {level}", partial(image, level))
        builder.add(f"painting {level}", CUBE)
    textures = builder.scene(VIEW).textures
    assert [(texture.name, texture.pixels[0, 0, 0]) for texture in textures] == [
        ("painting 100", 100),
        ("painting 200", 200),
    ]


def test_paints_are_linear_and_no_darker_or_lighter_than_real_ones() -> None:
    builder = Builder("paints")
    for colour in ("#000000", "#808080", "#ffffff"):
        builder.paints(f"the {colour} 0.5")
        builder.add("the", CUBE)
    materials = builder.scene(VIEW).materials
    albedos = [material.base_color[0] for material in materials]
    assert albedos == pytest.approx([0.05, 0.2158605, 0.85])
    assert [material.roughness for material in materials] == [0.5] * 3


def test_a_name_that_no_material_has_is_an_error() -> None:
    with pytest.raises(KeyError, match="brass"):
        Builder("empty").add("brass", CUBE)

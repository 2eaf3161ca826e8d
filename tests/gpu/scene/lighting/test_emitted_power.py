from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gpu.scene.assemble import assemble
from gpu.scene.lighting.emitted_power import emitted_power
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import AlphaMode, Doubles, Material, Scene, Texture, TextureSlot, Wrap

SQUARE = np.array([[10.0, 0, 0], [12, 0, 0], [12, 2, 0], [10, 2, 0]])
UV = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
PIXELS = np.full((4, 8, 4), 255, np.uint8)
PIXELS[:, :2, 3] = 0
PIXELS[:, 4:, :3] = 0
SHEET = Texture("sheet", PIXELS, srgb=True, wrap_s=Wrap.CLAMP, nearest=True)
WHOLE = 4.0 * np.pi


def scene_of(uvs: Doubles = UV, colors: Doubles | None = None, **material: Any) -> Scene:
    """A square of area 4 that emits radiance 1."""
    part = MeshPart(SQUARE, TRIANGLES, uvs=(uvs,), colors=colors)
    made = Material(emission=(1.0, 1.0, 1.0), **material)
    return assemble("lamp", SceneParts([part], [made], [SHEET]))


@pytest.mark.parametrize(
    ("material", "share"),
    [
        ({}, 1.0),
        ({"double_sided": False}, 1.0),
        ({"double_sided": True}, 2.0),
        ({"unlit": True}, 0.0),
        ({"emission_slot": TextureSlot(0)}, 0.5),
        ({"base_color_slot": TextureSlot(0)}, 1.0),
        ({"base_color_slot": TextureSlot(0), "alpha_mode": AlphaMode.MASK}, 0.75),
        ({"base_color_slot": TextureSlot(0), "alpha_mode": AlphaMode.BLEND, "double_sided": True}, 1.5),
        ({"base_color_slot": TextureSlot(0), "emission_slot": TextureSlot(0), "alpha_mode": AlphaMode.MASK}, 0.25),
        ({"base_color": (1.0, 1.0, 1.0, 0.4), "alpha_mode": AlphaMode.BLEND}, 0.4),
        ({"base_color": (1.0, 1.0, 1.0, 0.4), "alpha_mode": AlphaMode.MASK, "alpha_cutoff": 0.3}, 1.0),
    ],
)
def test_power_is_of_the_sides_that_emit_and_of_what_alpha_leaves(material: dict[str, Any], share: float) -> None:
    assert emitted_power(scene_of(**material))[0] == pytest.approx(share * WHOLE, rel=0.01)


def test_only_the_part_of_a_texture_that_is_shown_counts() -> None:
    whole = scene_of(UV * [0.25, 1.0] + [0.25, 0.0], emission_slot=TextureSlot(0))
    assert emitted_power(whole)[0] == pytest.approx(WHOLE, rel=0.01)
    none = scene_of(UV * [0.25, 1.0] + [0.6, 0.0], emission_slot=TextureSlot(0))
    assert emitted_power(none)[0] == pytest.approx(0.0, abs=0.01)


def test_alpha_of_vertices_counts() -> None:
    colors = np.ones((4, 4))
    colors[:2, 3] = 0.0  # alpha rises from 0 to 1 along the square
    assert emitted_power(scene_of(colors=colors, alpha_mode=AlphaMode.MASK))[0] == pytest.approx(WHOLE / 2.0, rel=0.01)


def test_triangles_are_looked_for_of_materials_that_emit_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of()
    many = replace(scene, materials=(*scene.materials, *[Material()] * 99))
    looked, found = [], np.flatnonzero
    monkeypatch.setattr(np, "flatnonzero", lambda of: looked.append(of) or found(of))
    assert np.array_equal(emitted_power(many)[:1], emitted_power(scene))
    assert len(looked) == 2

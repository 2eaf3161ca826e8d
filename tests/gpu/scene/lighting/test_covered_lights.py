"""Which lights are covered by a surface that lets nothing out, and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey

from gpu.scene.assemble import assemble
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import AlphaMode, Light, LightKind, Material

AT = np.array([0.1, 0.2, 0.0])
LAMP = Light("lamp", LightKind.POINT, (1.0, 1.0, 1.0), position=tuple(AT))


def bulb(sides: int = 6, half: float = 0.01) -> list[MeshPart]:
    """A small cube about the lamp, of so many sides."""
    return [replace(it, positions=it.positions + AT, objects=("bulb",)) for it in box(1, half)][:sides]


def notes(parts: list[MeshPart], lamp: Light = LAMP, of: Material | None = None) -> list[str]:
    found = assemble("room", SceneParts([*box(), *parts], [grey(0.5), of or grey(0.5)], lights=[lamp]))
    return [note for note in found.report.notes if "covered" in note]


def test_a_light_in_an_opaque_bulb_is_told_and_so_is_the_bulb() -> None:
    (note,) = notes(bulb())
    assert note.startswith("lamp: it is covered by “bulb”, which lets none of its light out")


@pytest.mark.parametrize(
    ("parts", "lamp"),
    [
        ([], LAMP),  # a room is no bulb
        (bulb(sides=5), LAMP),
        (bulb(half=0.2), LAMP),
        (bulb(), replace(LAMP, position=(0.1, 0.3, 0.0))),
        (bulb(), replace(LAMP, intensity=(0.0, 0.0, 0.0))),
        (bulb(), replace(LAMP, kind=LightKind.DIRECTIONAL)),
    ],
)
def test_others_are_not_covered(parts: list[MeshPart], lamp: Light) -> None:
    assert notes(parts, lamp) == []


@pytest.mark.parametrize(
    "glass",
    [
        Material(transmission=1.0, roughness=0.0),
        Material(transmission=0.5, roughness=0.8),
        Material(base_color=(1.0, 1.0, 1.0, 0.2), alpha_mode=AlphaMode.BLEND),
    ],
)
def test_glass_lets_light_out(glass: Material) -> None:
    assert notes(bulb(), of=glass) == []

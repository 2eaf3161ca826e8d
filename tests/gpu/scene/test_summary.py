import json
from math import cos, pi
from pathlib import Path

import numpy as np
import pytest
from gltf_motion import moving

from gpu.scene.assemble import assemble
from gpu.scene.import_options import ImportOptions
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.summary import memory_bytes, summarise, summary_text
from gpu.scene.types import Light, LightKind, Material, Scene, Texture, TextureSlot

QUAD = np.array([[0.0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
PART = MeshPart(QUAD + 10, np.array([*TWO, [0, 0, 1]]))


def scene_of(*lights: Light, **material: object) -> Scene:
    """A room of which the file says nothing but its triangles."""
    pixels = np.zeros((1, 2, 4), np.uint8)
    pixels[0, 0] = 255
    textures = [Texture("half", pixels, srgb=True), Texture("half", pixels, srgb=False)]
    return assemble("room", SceneParts([PART], [Material("m", **material)], textures, lights, ignored=("that",)))


def test_lengths_are_in_world_units() -> None:
    summary = summarise(scene_of())
    assert np.allclose(summary["bounds"]["min"], (10, 10, 10))
    assert np.allclose(summary["bounds"]["max"], (14, 12, 10))
    assert (summary["triangles"], summary["dropped_triangles"]) == (2, 1)
    assert summary["materials"] == [{"id": "m", "name": "m", "triangles": 2, "area": pytest.approx(8.0)}]


def test_an_area_lights_power() -> None:
    (light,) = summarise(scene_of(emission=(1.0, 2.0, 0.0)))["lights"]
    assert light["kind"] == "area"
    assert np.allclose(light["power"], (8 * pi, 16 * pi, 0))


def test_an_emissive_texture_counts_with_its_mean() -> None:
    (light,) = summarise(scene_of(emission=(1.0, 1.0, 1.0), emission_slot=TextureSlot(0)))["lights"]
    assert np.allclose(light["power"], 4 * pi)


def test_the_power_of_punctual_lights_is_that_of_the_file() -> None:
    inner, outer = cos(0.2), cos(0.5)
    lights = [
        Light("p", LightKind.POINT, (3.0, 2.0, 1.0), (1.0, 1.0, 1.0)),
        Light("s", LightKind.SPOT, (5.0, 5.0, 5.0), cos_inner=inner, cos_outer=outer),
        Light("d", LightKind.DIRECTIONAL, (7.0, 7.0, 7.0)),
    ]
    point, spot, sun = summarise(scene_of(*lights))["lights"]
    assert np.allclose(point["power"], np.array([3, 2, 1]) * 4 * pi)
    cosines = np.linspace(outer, 1.0, 100_001)
    falloff = np.clip((cosines - outer) / (inner - outer), 0.0, 1.0) ** 2
    assert np.allclose(spot["power"], 5 * 2 * pi * np.trapezoid(falloff, cosines), rtol=1e-4)
    assert sun["irradiance"] == [7.0, 7.0, 7.0]


def test_shared_pixels_count_once() -> None:
    scene = scene_of()
    assert memory_bytes(scene) == 6 * 3 * 4 * 2 + 6 * 2 * 4 + 2 * 3 * 4 + 2 * 4 + 8


def test_text_and_json_say_what_was_changed() -> None:
    summary = summarise(scene_of())
    assert json.loads(json.dumps(summary)) == summary
    text = summary_text(summary)
    for part in ("room", "2 triangles", "size 4 2 0 m, from 10 10 10 to 14 12 10",
                 "+Y is up, a unit is 1 m", "half: 2×1, colour", "sky: sky, 1 1 1 W/m²/sr", "ignored: that",
                 "dropped: 1 triangle w", "1 camera\n",
                 "note: the scene has no light", "default: perspective"):  # fmt: skip
        assert part in text


def test_coordinates_are_those_of_the_file_to_the_millimetre() -> None:
    part = MeshPart(QUAD[:, [0, 2, 1]] * 1000.0 + (456_789_123.0, 5_432_100_456.0, 120_789.0), TWO)
    found = SceneParts([part], [Material("m")], up="z", metres_per_unit=0.001, choices={"storey": ["ground", "first"]})
    summary = summarise(assemble("survey", found, options=ImportOptions(origin=(456_000_000, 5_432_000_000, 0))))
    assert summary["frame"] == {"up": "z", "metres_per_unit": 0.001, "origin": [456_000_000, 5_432_000_000, 0]}
    assert np.allclose(summary["size"], (4, 2, 0))
    assert np.allclose(summary["bounds"]["min"], (456_789_123, 5_432_100_456, 120_789), rtol=1e-15)
    assert np.allclose(summary["bounds"]["max"], (456_793_123, 5_432_100_456, 122_789), rtol=1e-15)
    text = summary_text(summary)
    for part in ("to 456793123 5432100456 122789 in the file", "+Z is up, a unit is 0.001 m",
                 "metres count from 456000000 5432000000 0", "storey: one of ground, first"):  # fmt: skip
        assert part in text


def test_animations_are_listed_with_their_lengths(tmp_path: Path) -> None:
    summary = summarise(moving(tmp_path).load())
    assert summary["animations"] == [{"id": "wave", "seconds": 2.0}]
    assert summary_text(summary).endswith("  1 animation\n    wave: 2 s")

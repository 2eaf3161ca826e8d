"""What pointers change (KHR_animation_pointer) beside files that say the same without time."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile

from gpu.scene.edits import LightEdit, SceneEdits, edited
from gpu.scene.types import Scene

SECONDS = 2.0
LIGHTS = "/extensions/KHR_lights_punctual/lights/0"
# By pointer, what there is at the beginning, half-way and at the end; outside of their range at the end.
KEYS: dict[str, list[Any]] = {
    "/materials/0/pbrMetallicRoughness/baseColorFactor": [[1, 0.5, 0, 1], [0.5, 0.5, 0.25, 1], [0, 0.5, 2, 1]],
    "/materials/0/pbrMetallicRoughness/metallicFactor": [0, 0.5, 1],
    "/materials/0/pbrMetallicRoughness/roughnessFactor": [1, 0.75, 0.5],
    "/materials/0/emissiveFactor": [[0, 0, 0], [0.5, 0.25, 0], [1, 0, 0.5]],
    "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength": [1, 8, 2],
    "/materials/0/alphaCutoff": [0.5, 0.25, -1],
    "/materials/0/extensions/KHR_materials_ior/ior": [1.5, 1.25, 2],
    "/materials/0/extensions/KHR_materials_transmission/transmissionFactor": [0, 0.25, 0],
    "/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor": [0, 0.5, 1],
    "/materials/0/extensions/KHR_materials_sheen/sheenColorFactor": [[0, 0, 0], [1, 0.5, 0], [2, 1, 0.5]],
    "/materials/0/extensions/KHR_materials_sheen/sheenRoughnessFactor": [0, 0.5, 1],
    "/materials/0/extensions/KHR_materials_iridescence/iridescenceFactor": [0, 0.5, 2],
    "/materials/0/extensions/KHR_materials_iridescence/iridescenceIor": [1.5, 1.25, 0.5],
    "/materials/0/extensions/KHR_materials_iridescence/iridescenceThicknessMinimum": [100, 200, -100],
    "/materials/0/extensions/KHR_materials_iridescence/iridescenceThicknessMaximum": [400, 500, 600],
    "/materials/0/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor": [0, 0.5, 2],
    "/materials/0/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor": [
        [1, 1, 1],
        [1, 0.5, 0],
        [0, 0.5, 2],
    ],
    f"{LIGHTS}/color": [[1, 1, 1], [1, 0.5, 0], [0, 1, 0]],
    f"{LIGHTS}/intensity": [2, 4, 0.5],
    f"{LIGHTS}/spot/innerConeAngle": [0, 0.25, 3],
    f"{LIGHTS}/spot/outerConeAngle": [0.5, 0.75, 1],
}
RANGES = {"baseColorFactor": (0, 1), "alphaCutoff": (0, 1), "innerConeAngle": (0, 1)}


def written(folder: Path, time: float | None = None, moves: Collection[str] = KEYS.keys()) -> Scene:
    """A file in which all that moves is as at `time`, and without animation; None: with one, and all as at 0."""
    gltf = GltfFile(folder)
    gltf.json |= {
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "name": "lamp"}]}},
        "materials": [{}],
    }
    gltf.mesh_node(gltf.primitive(TRIANGLE * 4, material=0))
    gltf.add("nodes", translation=[0, 0, 1], extensions={"KHR_lights_punctual": {"light": 0}})
    for pointer, keys in KEYS.items():
        place: Any = gltf.json
        *path, last = pointer.removeprefix("/").split("/")
        for name in path:
            place = place[int(name)] if isinstance(place, list) else place.setdefault(name, {})
        place[last] = np.clip(keys[int(time or 0) if pointer in moves else 0], *RANGES.get(last, (None, None))).tolist()
    if time is None:
        samplers = [
            {"input": gltf.accessor(np.float32([0, 1, SECONDS])), "output": gltf.accessor(np.float32(KEYS[pointer]))}
            for pointer in moves
        ]
        channels = [
            {
                "sampler": number,
                "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": one}}},
            }
            for number, one in enumerate(moves)
        ]
        gltf.json["animations"] = [{"samplers": samplers, "channels": channels}]
    return gltf.load()


@pytest.mark.parametrize("time", [0.0, 1.0, 2.0])
def test_materials_and_lights_are_those_of_a_file_that_says_so(tmp_path: Path, time: float) -> None:
    still, found = written(tmp_path, time), edited(written(tmp_path), SceneEdits(time=time))
    assert found.materials == still.materials
    assert found.lights == still.lights


@pytest.mark.parametrize("alone", list(KEYS))
def test_one_that_changes_alone_goes_with_what_the_file_says(tmp_path: Path, alone: str) -> None:
    still = written(tmp_path, 1.0, [alone])
    found = edited(written(tmp_path, moves=[alone]), SceneEdits(time=1.0))
    assert (found.materials, found.lights) == (still.materials, still.lights)


def test_what_is_hidden_is_not_there_and_its_lights_are_dark(tmp_path: Path) -> None:
    pointer = "/nodes/1/extensions/KHR_node_visibility/visible"
    gltf = GltfFile(tmp_path)
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    gltf.mesh_node()
    gltf.mesh_node(gltf.primitive(TRIANGLE + 2), children=[2])
    gltf.mesh_node(gltf.primitive(TRIANGLE + 4), extensions={"KHR_lights_punctual": {"light": 0}})
    times, values = (gltf.accessor(np.float32(times)) for times in ([0, 1, 2], [1, 0, 1]))
    target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}
    samplers = [{"input": times, "output": values, "interpolation": "STEP"}]
    gltf.json["animations"] = [{"samplers": samplers, "channels": [{"sampler": 0, "target": target}]}]
    scene = gltf.load()
    hidden, shown = (edited(scene, SceneEdits(time=time)) for time in (1.5, 2.0))
    assert hidden.triangles.tolist() == scene.triangles[:1].tolist()
    assert (hidden.lights[0].intensity, hidden.lights[0].path_color) == ((0.0, 0.0, 0.0), scene.lights[0].intensity)
    assert (shown.triangles.tolist(), shown.lights) == (scene.triangles.tolist(), scene.lights)


def test_light_that_changes_is_drawn_by_as_in_the_file(tmp_path: Path) -> None:
    scene = written(tmp_path)
    for edits in (SceneEdits(time=1.0), SceneEdits(time=1.0, lights={"lamp": LightEdit(intensity=0.5)})):
        found = edited(scene, edits)
        assert found.lights[0].path_color == scene.lights[0].intensity


def test_where_only_materials_and_lights_change_geometry_is_the_same(tmp_path: Path) -> None:
    scene = written(tmp_path)
    found = edited(scene, SceneEdits(time=1.0))
    assert found.vertices is scene.vertices
    assert found.triangles is scene.triangles

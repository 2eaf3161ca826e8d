"""Whole files: the Khronos validator's corpus, Khronos' samples, and one file broken in every place."""

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile

from gpu.errors import SceneError
from gpu.scene.formats.gltf import load_gltf
from gpu.scene.limits import SceneLimits

JUNK = [None, -1, 0.5, 2**70, 1e300, 99_999_999, "", "x", True, [], {}, [None], [1e39] * 3, {"a": 1}]
SMALL = SceneLimits(max_vertices=10_000, max_triangles=10_000)


def gltf_files(folder: Path) -> list[Path]:
    return sorted([*folder.rglob("*.glb"), *folder.rglob("*.gltf")])


def refusal(path: Path, limits: SceneLimits) -> str:
    """The error that loading `path` gives, or its name where it loads; another exception is a failure."""
    try:
        load_gltf(path, limits)
    except SceneError as error:
        return str(error)
    return str(path)


def test_malformed_files_load_or_are_refused(shared: Path) -> None:
    files = gltf_files(shared / "malformed")
    assert len(files) > 300
    for path in files:
        assert refusal(path, SceneLimits()).startswith(str(path))


def test_samples_load_and_say_what_is_ignored(shared: Path) -> None:
    for path in gltf_files(shared / "gltf-samples"):
        scene = load_gltf(path)
        json_text = path.read_bytes()
        assert np.isfinite(scene.vertices).all()
        assert (b"KHR_materials_iridescence" in json_text) == any(material.has_film for material in scene.materials)
        assert (b'"animations"' in json_text) == (scene.motion is not None)


@pytest.mark.parametrize(
    ("name", "triangles", "lights", "emitters"),
    [
        ("conference", 146_224, 0, 2),
        ("living-room", 385_833, 0, 4),
        ("staircase", 262_663, 0, 1),
        ("cornell-box", 36, 0, 1),
        ("veach-bidir", 11_544, 0, 2),
        ("sponza", 262_267, 1, 0),
    ],
)
def test_the_benchmark_scenes(shared: Path, name: str, triangles: int, lights: int, emitters: int) -> None:
    scene = load_gltf(shared / "scenes" / f"{name}.glb")
    assert len(scene.triangles) + scene.report.dropped_triangles == triangles
    assert len(scene.lights) == lights
    assert sum(any(material.emission) for material in scene.materials) == emitters
    assert len(scene.cameras) == 1
    assert scene.sky is None
    assert scene.report.ignored == ()


def places(value: Any, path: tuple = ()) -> Iterator[tuple]:
    if path:
        yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in inner:
        yield from places(item, (*path, key))


def test_junk_in_any_place_is_refused_or_does_not_matter(gltf: GltfFile) -> None:
    gltf.add("images", uri="none.png")
    gltf.add("textures", source=0, sampler=gltf.add("samplers", wrapS=33071))
    gltf.add("materials", emissiveFactor=[1, 1, 1], extensions={"KHR_materials_ior": {"ior": 1.5}})
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0})
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 1}}]}}
    sparse = {
        "count": 1,
        "indices": {"bufferView": gltf.view(b"\x01"), "componentType": 5121},
        "values": {"bufferView": gltf.view(TRIANGLE[1:2].tobytes())},
    }
    shift = gltf.accessor(np.zeros((3, 3), np.float32))
    primitive = gltf.primitive(gltf.accessor(TRIANGLE, sparse=sparse), [0, 1, 2], material=0, mode=5,
                               targets=[{"POSITION": shift}])  # fmt: skip
    instances = {"attributes": {"TRANSLATION": gltf.accessor(np.zeros((2, 3), np.float32))}}
    gltf.mesh_node(primitive, mesh={"weights": [1.0]}, extensions={"EXT_mesh_gpu_instancing": instances})
    lit = {"KHR_lights_punctual": {"light": 0}}
    gltf.add("nodes", children=[0], camera=0, rotation=[0, 0, 0, 1], extensions=lit)
    gltf.json.update(scenes=[{"nodes": [1]}], scene=0)
    assert len(gltf.load().triangles) == 2
    sound, text = copy.deepcopy(gltf.json), json.dumps(gltf.json)
    for number, path in enumerate(places(sound)):
        for junk in JUNK[number % 3 :: 3]:
            gltf.json = json.loads(text)
            place = gltf.json
            for key in path[:-1]:
                place = place[key]
            place[path[-1]] = junk
            if gltf.json.get("buffers") == sound["buffers"]:  # write() would repair it
                assert "scene.glb" in refusal(gltf.write(), SMALL), json.dumps(gltf.json)

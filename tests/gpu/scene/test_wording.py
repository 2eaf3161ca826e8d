import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gpu.scene.load import load_scene
from gpu.scene.types import LoadReport, Scene
from gpu.scene.wording import MOST_CHOICE, MOST_CHOICES, MOST_NAME, MOST_SENTENCE, MOST_SENTENCES, shortened


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("cornell-box")


@pytest.mark.parametrize("extra", [0, 1, 10**6])
def test_names_are_cut_at_their_limit(scene: Scene, extra: int) -> None:
    name = (MOST_NAME + extra) * "n"
    said = name if extra == 0 else name[: MOST_NAME - 1] + "…"
    long = replace(
        scene,
        cameras=tuple(replace(camera, name=name) for camera in scene.cameras),
        materials=tuple(replace(material, name=name) for material in scene.materials),
    )
    result = shortened(long)
    assert {thing.name for thing in (*result.cameras, *result.materials)} == {said}
    assert result.vertices is scene.vertices


@pytest.mark.parametrize("extra", [0, 1, 5000])
def test_too_many_sentences_are_counted(scene: Scene, extra: int) -> None:
    said = tuple(f"{number}" for number in range(MOST_SENTENCES + extra))
    report = shortened(replace(scene, report=LoadReport(said, 3, ("s" * (MOST_SENTENCE + 1),)))).report
    assert report.ignored == said[:MOST_SENTENCES] + ((f"{extra} more like these",) if extra else ())
    assert report.dropped_triangles == 3
    assert report.notes == ("s" * (MOST_SENTENCE - 1) + "…",)


def test_choices_that_cannot_be_told_are_not_offered(scene: Scene) -> None:
    whole = MOST_CHOICE * "v"
    result = shortened(replace(scene, choices={"variant": ["red", whole, whole + "v", "", "\ud800"]}))
    assert result.choices == {"variant": ("red", whole)}
    assert result.report.notes[-1].startswith("3 of 5 choices of a variant are not listed")
    many = shortened(replace(scene, choices={"storey": [str(number) for number in range(MOST_CHOICES + 9)]}))
    assert len(many.choices["storey"]) == MOST_CHOICES
    assert shortened(replace(scene, choices={"storey": ["0"]})).report == scene.report


def test_what_a_file_calls_things_is_cut_when_it_is_read(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
    camera = {"name": 10**6 * "N", "type": "perspective", "perspective": {"yfov": 1, "znear": 1}}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(points), "uri": "points.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}], "name": "\ud800"}],
        "nodes": [{"mesh": 0}, {"camera": 0, "name": 10**6 * "N"}],
        "scenes": [{"nodes": [0, 1]}],
        "cameras": [camera],
    }
    (tmp_path / "points.bin").write_bytes(points)
    (tmp_path / "odd.gltf").write_text(json.dumps(document))
    read = load_scene(str(tmp_path / "odd.gltf"))
    assert [len(camera.name) for camera in read.cameras] == [MOST_NAME]

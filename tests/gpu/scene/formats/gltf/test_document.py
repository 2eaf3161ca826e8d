import struct
from pathlib import Path
from typing import Any

import pytest
from gltf_file import GltfFile

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.formats.gltf import load_gltf
from gpu.scene.formats.gltf.document import open_document
from gpu.scene.limits import SceneLimits


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not a glTF file, neither GLB nor JSON"),
        (b"[" * 100_000, "not a glTF file, neither GLB nor JSON"),
        (b"\xff\xfe", "not a glTF file, neither GLB nor JSON"),
        (b"[]", "must be an object"),
        (b'{"asset": {"version": "1.0"}}', "asset.version: glTF '1.0'"),
        (b'{"asset": {"version": "2.1", "minVersion": "2.1"}}', "asset.minVersion: needs glTF '2.1'"),
        (b"glTF" + struct.pack("<IIII", 1, 20, 0, 0x4E4F534A), "version 1"),
        (b"glTF" + struct.pack("<IIII", 2, 99, 0, 0x4E4F534A), "cut off"),
        (b"glTF" + struct.pack("<IIII", 2, 20, 9, 0x4E4F534A), "beyond the file's end"),
        (b"glTF" + struct.pack("<IIII", 2, 20, 0, 0x004E4942), "first chunk must be JSON"),
        (b"glTF" + struct.pack("<IIII", 2, 12, 0, 0x4E4F534A), "no JSON chunk"),
    ],
)
def test_a_broken_container_is_named(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "broken.gltf"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=r"broken\.gltf") as caught:
        load_gltf(path)
    assert says in str(caught.value)


TEXT = '{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0, "name": "Tür"}], "scene": NaN, "skins": Infinity}'


@pytest.mark.parametrize(
    ("encoding", "says"), [("utf-8", ""), ("utf-8-sig", "utf-8-sig"), ("utf-16", "utf-16"), ("cp1252", "not UTF-8")]
)
def test_text_in_other_encodings_is_read_and_said(tmp_path: Path, encoding: str, says: str) -> None:
    (tmp_path / "a.gltf").write_bytes(TEXT.encode(encoding))
    document = open_document(tmp_path / "a.gltf", SceneLimits())
    assert document.root.objects("nodes")[0].name() == "Tür"
    assert says in "".join(document.notes.sentences())
    assert bool(says) == bool(document.notes.sentences())


@pytest.mark.parametrize("asset", [None, [], {}, {"version": 2.0}, {"version": "two"}])
def test_a_file_that_does_not_say_its_version_is_of_2(gltf: GltfFile, asset: Any) -> None:
    gltf.mesh_node()
    gltf.json["asset"] = asset
    assert any("asset" in note for note in gltf.load().report.notes) == (asset != {"version": 2.0})


def test_what_cannot_be_read_is_left_out_unless_it_is_forbidden(gltf: GltfFile) -> None:
    document = open_document(gltf.write(), SceneLimits())

    def broken() -> None:
        raise SceneError("scene.glb", "lights[3]", "has no type")

    def forbidden() -> None:
        raise ForbiddenError("scene.glb", "lights[3]", "is outside")

    assert document.attempt(broken, "the light") is None
    assert document.ignored.sentences() == ("lights[3]: has no type; the light was left out",)
    assert document.attempt(lambda: 7, "the light") == 7
    with pytest.raises(ForbiddenError):
        document.attempt(forbidden, "the light")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"nothing\.glb: cannot be read: No such file"):
        load_gltf(tmp_path / "nothing.glb")


def test_a_file_over_the_limit_is_refused(gltf: GltfFile) -> None:
    gltf.mesh_node()
    with pytest.raises(SceneError, match="max_file_bytes"):
        gltf.load(SceneLimits(max_file_bytes=100))


def test_trailing_bytes_after_a_glb_are_ignored_and_said(gltf: GltfFile) -> None:
    gltf.mesh_node()
    path = gltf.write()
    path.write_bytes(path.read_bytes() + b"more")
    scene = load_gltf(path)
    assert len(scene.triangles) == 1
    assert "bytes after the end that the GLB header says were ignored (4)" in scene.report.notes

import struct
from pathlib import Path

import pytest
from gltf_file import GltfFile

from gpu.errors import SceneError
from gpu.scene.gltf import load_gltf
from gpu.scene.limits import SceneLimits


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not a glTF file"),
        (b"[" * 100_000, "not a glTF file"),
        (b'{"asset": {"version": "2.0"}, "x": NaN}', "NaN is not JSON"),
        (b"\xff\xfe", "not a glTF file"),
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


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"nothing\.glb: cannot be read: No such file"):
        load_gltf(tmp_path / "nothing.glb")


def test_a_file_over_the_limit_is_refused(gltf: GltfFile) -> None:
    gltf.mesh_node()
    with pytest.raises(SceneError, match="max_file_bytes"):
        gltf.load(SceneLimits(max_file_bytes=100))


def test_trailing_bytes_after_a_glb_are_ignored(gltf: GltfFile) -> None:
    gltf.mesh_node()
    path = gltf.write()
    path.write_bytes(path.read_bytes() + b"more")
    assert len(load_gltf(path).triangles) == 1

import base64
import json
from pathlib import Path

import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError
from gpu.scene.formats.gltf import load_gltf


def text_file(gltf: GltfFile, uri: str) -> Path:
    """The triangle as a .gltf whose buffer is at `uri`."""
    gltf.mesh_node()
    gltf.json["buffers"] = [{"byteLength": len(gltf.binary), "uri": uri}]
    path = gltf.folder / "scene.gltf"
    path.write_text(json.dumps(gltf.json))
    return path


@pytest.mark.parametrize("head", ["data:application/octet-stream;base64,", "DATA:;base64,"])
def test_a_buffer_in_a_data_uri(gltf: GltfFile, head: str) -> None:
    path = text_file(gltf, head + base64.b64encode(TRIANGLE.tobytes()).decode())
    assert np.array_equal(corners(load_gltf(path)), [TRIANGLE])


@pytest.mark.parametrize(("uri", "name"), [("a%20b.bin", "a b.bin"), ("a b.bin", "a b.bin"), ("d/❤.bin", "d/❤.bin")])
def test_a_buffer_in_a_file_beside_the_scene(gltf: GltfFile, uri: str, name: str) -> None:
    file = gltf.folder / name
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(TRIANGLE.tobytes())
    assert np.array_equal(corners(load_gltf(text_file(gltf, uri))), [TRIANGLE])


@pytest.mark.parametrize(
    "uri",
    ["../secret.bin", "%2e%2e/secret.bin", "..%5Csecret.bin", "x/../../secret.bin", "/etc/hostname", "link.bin",
     "file:///etc/hostname", "http://127.0.0.1/x.bin", "C:\\x.bin", "missing.bin", "a\0b", "data:base64", "[",
     "data:;base64,!!!", "loop", "x" * 5000],
)  # fmt: skip
def test_nothing_outside_the_scenes_folder_is_read(gltf: GltfFile, uri: str) -> None:
    (gltf.folder.parent / "secret.bin").write_bytes(TRIANGLE.tobytes())
    (gltf.folder / "link.bin").symlink_to(gltf.folder.parent / "secret.bin")
    (gltf.folder / "loop").symlink_to("loop")
    with pytest.raises(SceneError, match=r"buffers\[0\]\.uri"):
        load_gltf(text_file(gltf, uri))


def test_a_buffer_that_is_too_short(gltf: GltfFile) -> None:
    (gltf.folder / "short.bin").write_bytes(b"1234")
    with pytest.raises(SceneError, match=r"buffers\[0\]: has 4 of 36 bytes"):
        load_gltf(text_file(gltf, "short.bin"))


def test_a_view_beyond_its_buffer(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.json["bufferViews"][0]["byteOffset"] = 8
    with pytest.raises(SceneError, match=r"bufferViews\[0\]: bytes 8 to 44 of a buffer of 36"):
        gltf.load()


def test_a_glb_without_its_binary_chunk(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.json["buffers"] = [{"byteLength": 36}]
    gltf.binary.clear()
    with pytest.raises(SceneError, match=r"buffers\[0\]: has no 'uri'"):
        gltf.load()

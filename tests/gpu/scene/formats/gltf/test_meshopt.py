import sys

import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError

meshopt = pytest.importorskip("meshopt")

INDICES = np.array([0, 1, 2], np.uint32)


def packed(
    gltf: GltfFile, data: bytes, stride: int, mode: str, name: str = "EXT_meshopt_compression", **more: object
) -> int:
    """A buffer view of 3 elements, packed, whose own buffer has nothing."""
    number = gltf.view(data)
    source = gltf.json["bufferViews"].pop(number)
    extension = {**source, "byteStride": stride, "count": 3, "mode": mode, **more}
    gltf.json["extensionsUsed"] = gltf.json["extensionsRequired"] = [name]
    return gltf.add("bufferViews", buffer=1, byteLength=3 * stride, extensions={name: extension})


def packed_mesh(gltf: GltfFile, positions: bytes, **more: object) -> None:
    view = packed(gltf, positions, more.pop("stride", 12), "ATTRIBUTES", **more)
    code, kind = more.get("code", 5126), "VEC3"
    position = gltf.add("accessors", bufferView=view, componentType=code, count=3, type=kind)
    view = packed(gltf, meshopt.encode_gltf_buffer(INDICES, "TRIANGLES"), 4, "TRIANGLES")
    indices = gltf.add("accessors", bufferView=view, componentType=5125, count=3, type="SCALAR")
    gltf.mesh_node({"attributes": {"POSITION": position}, "indices": indices})


def finish(gltf: GltfFile, **buffer: object) -> None:
    """Add the buffer that stands for what is not packed, after the file's own."""
    gltf.json["buffers"] = [{"byteLength": len(gltf.binary)}, {"byteLength": 1000, **buffer}]


def test_positions_and_indices(gltf: GltfFile) -> None:
    packed_mesh(gltf, meshopt.encode_gltf_buffer(TRIANGLE, "ATTRIBUTES"))
    finish(gltf)
    assert np.allclose(np.sort(corners(gltf.load())[0], axis=0), np.sort(TRIANGLE, axis=0))


def test_a_filter(gltf: GltfFile) -> None:
    rows = meshopt.encode_filter_exp(TRIANGLE, 15)
    packed_mesh(gltf, meshopt.encode_gltf_buffer(rows, "ATTRIBUTES"), filter="EXPONENTIAL")
    finish(gltf)
    assert np.allclose(np.sort(corners(gltf.load())[0], axis=0), np.sort(TRIANGLE, axis=0), atol=1e-3)


def test_the_name_of_khronos(gltf: GltfFile) -> None:
    packed_mesh(gltf, meshopt.encode_gltf_buffer(TRIANGLE, "ATTRIBUTES", 1), name="KHR_meshopt_compression")
    gltf.json["extensionsRequired"] = ["KHR_meshopt_compression", "EXT_meshopt_compression"]
    finish(gltf)
    assert len(gltf.load().triangles) == 1


@pytest.mark.parametrize(
    ("data", "more", "problem"),
    [
        (b"no packed data", {}, "not data that meshoptimizer packed"),
        (None, {"mode": "SOMETHING"}, "must be one of ATTRIBUTES"),
        (None, {"filter": "SOMETHING"}, "must be one of NONE"),
        (None, {"count": 900}, "not data that meshoptimizer packed"),
    ],
)
def test_broken_views(gltf: GltfFile, data: bytes | None, more: dict, problem: str) -> None:
    packed_mesh(gltf, data or meshopt.encode_gltf_buffer(TRIANGLE, "ATTRIBUTES"))
    gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(more)
    finish(gltf)
    with pytest.raises(SceneError, match=problem):
        gltf.load()


def without_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "meshopt", None)


def test_without_the_library_what_is_not_packed_is_read(gltf: GltfFile, monkeypatch: pytest.MonkeyPatch) -> None:
    packed_mesh(gltf, meshopt.encode_gltf_buffer(TRIANGLE, "ATTRIBUTES"))
    (gltf.folder / "plain.bin").write_bytes(TRIANGLE.tobytes() + INDICES.tobytes())
    gltf.json["bufferViews"][1]["byteOffset"] = 36
    finish(gltf, uri="plain.bin", byteLength=48)
    del gltf.json["extensionsRequired"]
    without_library(monkeypatch)
    scene = gltf.load()
    assert np.allclose(corners(scene)[0], TRIANGLE)
    assert any("needs the extra meshopt: pip install lumenwalk[meshopt]" in s for s in scene.report.ignored)


def test_without_the_library_a_file_that_needs_it_is_refused(gltf: GltfFile, monkeypatch: pytest.MonkeyPatch) -> None:
    packed_mesh(gltf, meshopt.encode_gltf_buffer(TRIANGLE, "ATTRIBUTES"))
    finish(gltf)
    without_library(monkeypatch)
    with pytest.raises(SceneError, match=r"needs the extra meshopt: pip install lumenwalk\[meshopt\]"):
        gltf.load()

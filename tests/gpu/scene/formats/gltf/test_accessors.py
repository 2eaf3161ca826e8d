import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError
from gpu.scene.formats.gltf.accessors import dequantised


def test_interleaved_attributes(gltf: GltfFile) -> None:
    rows = np.zeros((3, 8), np.float32)
    rows[:, :3], rows[:, 3:6], rows[:, 6:] = TRIANGLE, (0, 0, 2), TRIANGLE[:, :2]
    view = gltf.view(rows.tobytes(), byteStride=32)
    position, normal = (
        gltf.add("accessors", bufferView=view, byteOffset=start, componentType=5126, count=3, type="VEC3")
        for start in (0, 12)
    )
    gltf.mesh_node(gltf.primitive(position, NORMAL=normal))
    scene = gltf.load()
    assert np.array_equal(corners(scene), [TRIANGLE])
    assert np.array_equal(scene.normals, np.tile([0.0, 0.0, 1.0], (3, 1)))


def test_sparse_values_replace_those_of_the_view(gltf: GltfFile) -> None:
    sparse = {
        "count": 1,
        "indices": {"bufferView": gltf.view(np.array([2], np.uint8).tobytes()), "componentType": 5121},
        "values": {"bufferView": gltf.view(np.array([[0, 5, 0]], np.float32).tobytes())},
    }
    gltf.mesh_node(gltf.primitive(gltf.accessor(TRIANGLE, sparse=sparse)))
    assert np.array_equal(corners(gltf.load()), [[[0, 0, 0], [1, 0, 0], [0, 5, 0]]])


def test_sparse_values_without_a_view_replace_zeros(gltf: GltfFile) -> None:
    sparse = {
        "count": 2,
        "indices": {"bufferView": gltf.view(np.array([1, 2], np.uint16).tobytes()), "componentType": 5123},
        "values": {"bufferView": gltf.view(TRIANGLE[1:].tobytes())},
    }
    number = gltf.add("accessors", componentType=5126, count=3, type="VEC3", sparse=sparse)
    gltf.mesh_node(gltf.primitive(number))
    assert np.array_equal(corners(gltf.load()), [TRIANGLE])


def test_a_sparse_index_out_of_range(gltf: GltfFile) -> None:
    sparse = {
        "count": 1,
        "indices": {"bufferView": gltf.view(b"\x03"), "componentType": 5121},
        "values": {"bufferView": gltf.view(TRIANGLE[:1].tobytes())},
    }
    gltf.mesh_node(gltf.primitive(gltf.accessor(TRIANGLE, sparse=sparse)))
    with pytest.raises(SceneError, match=r"accessors\[0\]\.sparse\.indices"):
        gltf.load()


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.array([0, 255], np.uint8), [0.0, 1.0]),
        (np.array([-128, -127, 127], np.int8), [-1.0, -1.0, 1.0]),
        (np.array([0, 65535], np.uint16), [0.0, 1.0]),
        (np.array([-32768, 32767], np.int16), [-1.0, 1.0]),
    ],
)
def test_normalised_integers(values: np.ndarray, expected: list[float]) -> None:
    assert np.array_equal(dequantised(values, normalized=True), expected)
    assert np.array_equal(dequantised(values, normalized=False), values)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"count": 4}, "4 elements end at byte 48"),
        ({"byteOffset": 4}, "end at byte 40"),
        ({"count": 2**40}, "max_vertices"),
        ({"componentType": 5124}, "is not a component type"),
        ({"type": "VEC9"}, "not one that meshes have"),
        ({"type": "VEC2"}, "has 2 components, expected 3"),
        ({"bufferView": 7}, "7 does not exist"),
    ],
)
def test_broken_accessors_are_named(gltf: GltfFile, change: dict, says: str) -> None:
    gltf.mesh_node()
    gltf.json["accessors"][0].update(change)
    with pytest.raises(SceneError, match=r"accessors\[0\]") as caught:
        gltf.load()
    assert says in str(caught.value)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_positions_that_are_not_finite_are_refused(gltf: GltfFile, bad: float) -> None:
    positions = TRIANGLE.copy()
    positions[1, 2] = bad
    gltf.mesh_node(gltf.primitive(positions))
    with pytest.raises(SceneError, match=r"accessors\[0\]: element 1 is not finite"):
        gltf.load()


def test_values_that_no_triangle_uses_may_be_anything(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(np.float32([[np.nan, np.inf, 0], *TRIANGLE]), [1, 2, 3]))
    scene = gltf.load()
    assert np.array_equal(corners(scene), [TRIANGLE])
    assert not [note for note in scene.report.notes if "finite" in note]

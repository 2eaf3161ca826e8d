import DracoPy
import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError


def compressed(gltf: GltfFile, data: bytes, **attributes: int) -> None:
    extension = {"bufferView": gltf.view(data), "attributes": {"POSITION": 0, **attributes}}
    position = gltf.add("accessors", componentType=5126, count=3, type="VEC3")
    indices = gltf.add("accessors", componentType=5125, count=3, type="SCALAR")
    gltf.mesh_node({"attributes": {"POSITION": position}, "indices": indices,
                    "extensions": {"KHR_draco_mesh_compression": extension}})  # fmt: skip
    gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = ["KHR_draco_mesh_compression"]


def test_a_compressed_mesh(gltf: GltfFile) -> None:
    compressed(gltf, DracoPy.encode(TRIANGLE, np.array([[0, 1, 2]]), quantization_bits=16))
    triangles = corners(gltf.load())
    assert triangles.shape == (1, 3, 3)
    found = triangles[0][np.lexsort(triangles[0].T[::-1])]
    assert np.allclose(found, [[0, 0, 0], [0, 1, 0], [1, 0, 0]], atol=1e-4)
    assert np.cross(triangles[0][1] - triangles[0][0], triangles[0][2] - triangles[0][0])[2] > 0.9


def test_broken_data(gltf: GltfFile) -> None:
    compressed(gltf, b"DRACO and then nothing")
    with pytest.raises(SceneError, match=r"KHR_draco_mesh_compression: not a Draco mesh"):
        gltf.load()


def test_a_point_cloud_is_not_a_mesh(gltf: GltfFile) -> None:
    compressed(gltf, DracoPy.encode(TRIANGLE))
    with pytest.raises(SceneError, match="not a Draco mesh"):
        gltf.load()


def test_an_attribute_that_the_data_lacks(gltf: GltfFile) -> None:
    compressed(gltf, DracoPy.encode(TRIANGLE, np.array([[0, 1, 2]])), POSITION=7)
    with pytest.raises(SceneError, match=r"attributes\.POSITION: the Draco data has no attribute 7"):
        gltf.load()


def test_an_attribute_of_another_type(gltf: GltfFile) -> None:
    extra = {3: np.zeros((3, 1), np.float32)}
    compressed(gltf, DracoPy.encode(TRIANGLE, np.array([[0, 1, 2]]), generic_attributes=extra), POSITION=3)
    with pytest.raises(SceneError, match="another type"):
        gltf.load()

import numpy as np
import pytest
from gltf_file import GltfFile

from gpu.errors import SceneError
from gpu.scene.formats.gltf.transforms import local_matrices
from gpu.scene.formats.gltf.values import Value

HALF = float(np.sqrt(0.5))


def node(**raw: object) -> Value:
    return Value("a.gltf", "nodes[0]", raw)


def test_translation_rotation_and_scale() -> None:
    (matrix,) = local_matrices([node(translation=[1, 2, 3], rotation=[0, 0, 2 * HALF, 2 * HALF], scale=[2, 1, 1])])
    assert np.allclose(matrix @ [1, 0, 0, 1], [1, 4, 3, 1])  # scaled to 2, turned from x to y, moved
    assert np.allclose(matrix @ [0, 1, 0, 1], [0, 2, 3, 1])


def test_a_matrix_is_in_columns() -> None:
    (matrix,) = local_matrices([node(matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1])])
    assert np.array_equal(matrix[:3, 3], [5, 6, 7])


LAST = [*np.eye(4).reshape(-1)[:12], 2, 3, 4]


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        ({"matrix": [*LAST, 0.99999994]}, ""),
        ({"matrix": [*LAST, 0.5]}, "its last row must be 0, 0, 0, 1, not [0.0, 0.0, 0.0, 0.5]"),
        ({"matrix": [*LAST, 1], "scale": [2, 2, 2]}, "has both a matrix and"),
        ({"translation": [2, 3, 4], "rotation": [0, 0, 0, 0]}, "(0, 0, 0, 0): it turns nothing"),
        ({"translation": [2, 3, 4], "rotation": [0, 0, 0, 1.03]}, "whose length is not 1"),
    ],
)
def test_odd_transforms_are_mended(raw: dict, says: str) -> None:
    value = node(**raw)
    assert np.array_equal(local_matrices([value]), [[[1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 1, 4], [0, 0, 0, 1]]])
    assert [says in note for note in value.notes.sentences()] == [True] * bool(says)


@pytest.mark.parametrize("raw", [{"matrix": [0] * 15}, {"scale": [np.nan, 1, 1]}, {"translation": "x"}])
def test_broken_transforms(raw: dict) -> None:
    with pytest.raises(SceneError, match=r"nodes\[0\]"):
        local_matrices([node(**raw)])


def test_instances(gltf: GltfFile) -> None:
    count = 3
    attributes = {
        "TRANSLATION": gltf.accessor(np.array([[10 * i, 0, 0] for i in range(count)], np.float32)),
        "SCALE": gltf.accessor(np.array([[1, 1, 1], [2, 2, 2], [-1, 1, 1]], np.float32)),
    }
    gltf.mesh_node(extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}}, translation=[0, 5, 0])
    scene = gltf.load()
    world = scene.vertices / scene.placement.scale + scene.placement.centre
    assert np.allclose(world[scene.triangles[:, 0]], [[0, 5, 0], [10, 5, 0], [20, 6, 0]], atol=1e-5)
    assert np.allclose(scene.normals, (0, 0, 1))  # the mirrored one is wound the other way


def test_instances_of_different_number(gltf: GltfFile) -> None:
    attributes = {name: gltf.accessor(np.ones((count, 3), np.float32)) for name, count in
                  (("TRANSLATION", 2), ("SCALE", 3))}  # fmt: skip
    gltf.mesh_node(extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    with pytest.raises(SceneError, match=r"nodes\[0\]\.extensions\.EXT_mesh_gpu_instancing\.attributes"):
        gltf.load()

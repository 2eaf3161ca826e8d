import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits


def test_one_mesh_in_two_nodes(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.add("nodes", mesh=0, translation=[0, 0, 4])
    assert np.array_equal(corners(gltf.load()), [TRIANGLE, TRIANGLE + np.float32([0, 0, 4])])


def test_primitives_keep_their_materials(gltf: GltfFile) -> None:
    gltf.add("materials", name="a")
    gltf.add("materials", name="b")
    gltf.mesh_node(gltf.primitive(material=1), gltf.primitive(TRIANGLE + 1, material=0), gltf.primitive(TRIANGLE + 2))
    scene = gltf.load()
    assert [scene.materials[number].name for number in scene.triangle_material] == ["b", "a", "glTF default"]


def test_a_material_that_does_not_exist(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(material=0))
    with pytest.raises(SceneError, match=r"meshes\[0\]\.primitives\[0\]\.material: 0 does not exist, there are 0"):
        gltf.load()


def test_a_mesh_without_primitives(gltf: GltfFile) -> None:
    gltf.json.update(meshes=[{"primitives": []}], nodes=[{"mesh": 0}])
    with pytest.raises(SceneError, match=r"meshes\[0\]: has no primitives"):
        gltf.load()


@pytest.mark.parametrize("limits", [SceneLimits(max_triangles=999), SceneLimits(max_vertices=2999)])
def test_instances_count_against_the_limits_before_they_are_made(gltf: GltfFile, limits: SceneLimits) -> None:
    attributes = {"TRANSLATION": gltf.accessor(np.zeros((1000, 3), np.float32))}
    gltf.mesh_node(extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    with pytest.raises(SceneError, match="more than the"):
        gltf.load(limits)
    assert len(gltf.load().triangles) == 1000

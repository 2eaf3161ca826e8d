import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError


def skinned(gltf: GltfFile, joints: list[list[int]], weights: list[list[float]]) -> None:
    """The triangle on two joints: one at the origin, one moved up by 1 from where it was bound, at x = 1."""
    inverse = np.stack([np.eye(4), np.eye(4)]).astype(np.float32)
    inverse[1, 3, 0] = -1.0  # stored in columns
    first, second = gltf.add("nodes"), gltf.add("nodes", translation=[1, 1, 0])
    gltf.add("skins", joints=[first, second], inverseBindMatrices=gltf.accessor(inverse.reshape(2, 16)))
    primitive = gltf.primitive(JOINTS_0=np.uint8(joints), WEIGHTS_0=np.float32(weights))
    gltf.mesh_node(primitive, skin=0, translation=[100, 0, 0])  # a skinned mesh ignores its own node


def test_vertices_follow_their_joints(gltf: GltfFile) -> None:
    skinned(gltf, [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]], [[1, 0, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0, 0]])
    assert np.allclose(corners(gltf.load()), TRIANGLE + np.array([[0, 0, 0], [0, 1, 0], [0, 0.5, 0]]))


def test_a_joint_that_does_not_exist(gltf: GltfFile) -> None:
    skinned(gltf, [[2, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3)
    with pytest.raises(SceneError, match="JOINTS_0 names a joint that does not exist, there are 2"):
        gltf.load()


def test_a_skin_on_a_mesh_without_joints(gltf: GltfFile) -> None:
    gltf.add("skins", joints=[gltf.add("nodes")])
    gltf.mesh_node(skin=0)
    with pytest.raises(SceneError, match="is skinned but has no JOINTS_0"):
        gltf.load()

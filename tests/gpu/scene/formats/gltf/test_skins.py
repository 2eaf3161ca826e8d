import numpy as np
from gltf_file import TRIANGLE, GltfFile, corners


def skinned(gltf: GltfFile, joints: list[list[int]], weights: list[list[float]], **more: np.ndarray) -> None:
    """The triangle on two joints: one at the origin, one moved up by 1 from where it was bound, at x = 1."""
    inverse = np.stack([np.eye(4), np.eye(4)]).astype(np.float32)
    inverse[1, 3, 0] = -1.0  # stored in columns
    first, second = gltf.add("nodes"), gltf.add("nodes", translation=[1, 1, 0])
    gltf.add("skins", joints=[first, second], inverseBindMatrices=gltf.accessor(inverse.reshape(2, 16)))
    primitive = gltf.primitive(JOINTS_0=np.uint8(joints), WEIGHTS_0=np.float32(weights), **more)
    gltf.mesh_node(primitive, skin=0, translation=[100, 0, 0])  # a skinned mesh ignores its own node


def test_vertices_follow_their_joints(gltf: GltfFile) -> None:
    skinned(gltf, [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]], [[1, 0, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0, 0]])
    assert np.allclose(corners(gltf.load()), TRIANGLE + np.array([[0, 0, 0], [0, 1, 0], [0, 0.5, 0]]))


def test_a_joint_that_does_not_exist(gltf: GltfFile) -> None:
    skinned(gltf, [[2, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3)
    scene = gltf.load()
    assert "JOINTS name a joint that does not exist, there are 2; the skin was left out" in scene.report.ignored[0]
    assert np.allclose(corners(scene), TRIANGLE + np.float32([100, 0, 0]))


def test_a_skin_on_a_mesh_without_joints(gltf: GltfFile) -> None:
    gltf.add("skins", joints=[gltf.add("nodes")])
    gltf.mesh_node(skin=0)
    assert "is skinned but has no JOINTS_0" in gltf.load().report.ignored[0]


def test_a_vertex_has_more_than_four_joints(gltf: GltfFile) -> None:
    more = {"JOINTS_1": np.uint8([[1, 0, 0, 0]] * 3), "WEIGHTS_1": np.float32([[0.5, 0, 0, 0]] * 3)}
    skinned(gltf, [[0, 0, 0, 0]] * 3, [[0.5, 0, 0, 0]] * 3, **more)
    assert np.allclose(corners(gltf.load()), TRIANGLE + np.array([0, 0.5, 0]))


def test_weights_that_are_odd_are_mended(gltf: GltfFile) -> None:
    skinned(gltf, [[0, 99, 0, 0]] * 3, [[1, 0, np.nan, 0], [1, 0, 0, 0], [1, -1, 0, 0]])
    scene = gltf.load()
    assert np.allclose(corners(scene), TRIANGLE)
    assert any("WEIGHTS_0: 1 of 3 are not finite: 0 was used" in note for note in scene.report.notes)


def test_inverse_bind_matrices_that_are_not_finite_leave_the_skin_out(gltf: GltfFile) -> None:
    skinned(gltf, [[0, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3)
    gltf.binary[:4] = np.float32(np.nan).tobytes()
    assert "the skin was left out" in gltf.load().report.ignored[0]

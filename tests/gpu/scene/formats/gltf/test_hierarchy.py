import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError


def test_transforms_multiply_down_the_tree(gltf: GltfFile) -> None:
    child = gltf.mesh_node(translation=[1, 0, 0])
    gltf.add("nodes", children=[child], scale=[2, 2, 2])
    assert np.array_equal(corners(gltf.load()), [2 * (TRIANGLE + np.float32([1, 0, 0]))])


@pytest.mark.parametrize("scale", [[-1, 1, 1], [-1, -1, -1]])
def test_a_mirrored_node_keeps_its_front(gltf: GltfFile, scale: list[float]) -> None:
    gltf.mesh_node(gltf.primitive(NORMAL=np.tile(np.float32([0, 0, 1]), (3, 1))), scale=scale)
    scene = gltf.load()
    a, b, c = corners(scene)[0]
    assert np.allclose(scene.normals, (0, 0, scale[2]))
    assert np.dot(np.cross(b - a, c - a), scene.normals[0]) > 0.0


def test_a_deep_tree(gltf: GltfFile) -> None:
    gltf.mesh_node()
    for number in range(3000):
        gltf.add("nodes", children=[number], translation=[0, 0, 1])
    assert np.allclose(corners(gltf.load())[0, 0], (0, 0, 3000))


def test_only_the_shown_scene_is_read(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.mesh_node(translation=[9, 0, 0])
    gltf.json.update(scenes=[{"nodes": [0]}, {"nodes": [1], "name": "second"}], scene=1)
    scene = gltf.load()
    assert np.allclose(corners(scene)[0, 0], (9, 0, 0))
    assert scene.report.ignored == ("only one of 2 scenes is shown: second",)


@pytest.mark.parametrize(
    ("nodes", "roots", "says"),
    [
        ([{"children": [1]}, {"children": [0]}], [0], "another node's child"),
        ([{"children": [0]}], [0], "another node's child"),
        ([{"children": [2]}, {"children": [2]}, {}], [0, 1], "nodes[2]: is the child of two nodes"),
    ],
)
def test_nodes_that_are_no_tree(gltf: GltfFile, nodes: list, roots: list, says: str) -> None:
    gltf.json.update(nodes=nodes, scenes=[{"nodes": roots}])
    with pytest.raises(SceneError) as caught:
        gltf.load()
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scenes": [{"nodes": [0, 0]}]}, ""),
        ({"scenes": [{"nodes": [0, 7]}]}, "scenes[0].nodes[1]: 7 does not exist, there are 1; the node was left out"),
        ({"scenes": [{"nodes": [0]}], "scene": 2}, "scene: 2 does not exist, there are 1; the first scene was used"),
        ({"nodes": [{"mesh": 0, "children": [5]}]}, "nodes[0].children[0]: 5 does not exist"),
        ({"nodes": [{"mesh": 0, "children": {}}]}, "nodes[0].children: must be an array; it was left out"),
    ],
)
def test_what_a_tree_lists_wrongly_is_left_out(gltf: GltfFile, change: dict, says: str) -> None:
    gltf.mesh_node()
    gltf.json.update(change)
    scene = gltf.load()
    assert len(scene.triangles) == 1
    assert says in "\n".join(scene.report.ignored + scene.report.notes)


def test_a_loop_without_a_scene_shows_nothing(gltf: GltfFile) -> None:
    gltf.json["nodes"] = [{"children": [1]}, {"children": [0]}]
    with pytest.raises(SceneError, match="no triangles"):
        gltf.load()


def test_hidden_nodes_and_what_is_in_them_are_left_out(gltf: GltfFile) -> None:
    lamp = {"KHR_lights_punctual": {"light": 0}}
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    gltf.json["extensionsRequired"] = ["KHR_node_visibility"]
    hidden, shown = ({"KHR_node_visibility": {"visible": visible}} for visible in (False, True))
    child = gltf.mesh_node(translation=[9, 0, 0], extensions=shown | lamp)
    inner = gltf.add("nodes", children=[child])
    gltf.add("nodes", children=[inner], extensions=hidden)
    gltf.mesh_node(extensions=shown)
    scene = gltf.load()
    assert np.array_equal(corners(scene), [TRIANGLE])
    assert scene.lights == ()
    assert scene.report.ignored == ("nodes[2]: is hidden, with what is in it, and was left out",)


def test_a_visibility_that_is_no_truth_value_hides_nothing(gltf: GltfFile) -> None:
    gltf.mesh_node(extensions={"KHR_node_visibility": {"visible": "no"}})
    gltf.mesh_node(extensions={"KHR_node_visibility": {}})
    scene = gltf.load()
    assert len(scene.triangles) == 2
    assert "visible: must be one of True, False" in scene.report.notes[0]

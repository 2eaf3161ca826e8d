import cProfile
import pstats
from collections.abc import Callable

import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners

from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits

MOST_CALLS = 700  # of functions for an object: a file of 50,000 is to be read in seconds


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
    scene = gltf.load()
    assert scene.materials[0].name == "glTF default"
    says = "meshes[0].primitives[0].material: 0 does not exist, there are 0; glTF's default one was used"
    assert says in scene.report.notes


@pytest.mark.parametrize("mesh", [{"primitives": []}, {}, {"primitives": [{"attributes": {"NORMAL": 0}}]}])
def test_a_mesh_without_a_surface_is_left_out(gltf: GltfFile, mesh: dict) -> None:
    gltf.json.update(meshes=[mesh], nodes=[{"mesh": 0}])
    with pytest.raises(SceneError, match=r"no triangles; .*meshes\[0\].* has no p.* left out"):
        gltf.load()
    gltf.mesh_node()
    scene = gltf.load()
    assert len(scene.triangles) == 1
    assert "left out" in scene.report.ignored[0]


def test_a_mesh_that_does_not_exist_is_left_out(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.add("nodes", mesh=5)
    assert gltf.load().report.ignored == ("nodes[1].mesh: 5 does not exist, there are 1; the mesh was left out",)


def test_a_broken_skin_is_left_out(gltf: GltfFile) -> None:
    gltf.mesh_node(skin=3, translation=[0, 0, 1])
    scene = gltf.load()
    assert np.array_equal(corners(scene), [TRIANGLE + np.float32([0, 0, 1])])
    assert scene.report.ignored == ("nodes[0].skin: 3 does not exist, there are 0; the skin was left out",)


@pytest.mark.parametrize("limits", [SceneLimits(max_triangles=999), SceneLimits(max_vertices=2999)])
def test_instances_count_against_the_limits_before_they_are_made(gltf: GltfFile, limits: SceneLimits) -> None:
    attributes = {"TRANSLATION": gltf.accessor(np.zeros((1000, 3), np.float32))}
    gltf.mesh_node(extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    with pytest.raises(SceneError, match="more than the"):
        gltf.load(limits)
    assert len(gltf.load().triangles) == 1000


def add_object(gltf: GltfFile, number: int) -> None:
    primitive = gltf.primitive(indices=[0, 1, 2], NORMAL=np.tile(np.float32([0, 0, 1]), (3, 1)))
    gltf.mesh_node(primitive, name=f"object {number}", translation=[number, 0, 0], rotation=[0, 0, 0, 1])


def add_lamp(gltf: GltfFile, number: int) -> None:
    if not number:
        gltf.mesh_node()
        gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": []}}
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"].append({"type": "point"})
    gltf.add("nodes", extensions={"KHR_lights_punctual": {"light": number}})


def add_animated(gltf: GltfFile, number: int) -> None:
    if not number:
        gltf.json["meshes"] = [{"primitives": [gltf.primitive()]}]
        gltf.json["animations"] = [{"channels": [], "samplers": []}]
        gltf.accessor(np.float32([0, 1]))
        gltf.accessor(np.float32([[0, 0, 0], [1, 0, 0]]))
    node, (animation,) = gltf.add("nodes", mesh=0), gltf.json["animations"]
    animation["channels"].append({"sampler": number, "target": {"node": node, "path": "translation"}})
    animation["samplers"].append({"input": 1, "output": 2})


def add_skinned(gltf: GltfFile, number: int) -> None:
    if not number:
        joints, weights = np.zeros((3, 4), np.uint16), np.tile(np.float32([1, 0, 0, 0]), (3, 1))
        gltf.json["meshes"] = [{"primitives": [gltf.primitive(JOINTS_0=joints, WEIGHTS_0=weights)]}]
        gltf.json["skins"] = [{"joints": []}]
    gltf.json["skins"][0]["joints"].append(gltf.add("nodes", mesh=0, skin=0))


@pytest.mark.parametrize("add", [add_object, add_lamp, add_animated, add_skinned])
def test_loading_takes_as_long_for_the_last_as_for_the_first_of_many(
    gltf: GltfFile, add: Callable[[GltfFile, int], None]
) -> None:
    calls = []
    for number in range(161):
        add(gltf, number)
        if number in (0, 40, 80, 160):
            profile = cProfile.Profile()
            profile.runcall(gltf.load)
            calls.append(int(pstats.Stats(profile).total_calls))
    for_few, for_many = (calls[2] - calls[1]) / 40, (calls[3] - calls[2]) / 80
    assert for_many < 1.1 * for_few
    assert for_many < MOST_CALLS

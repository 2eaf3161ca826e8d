from dataclasses import replace

import numpy as np
import pytest
from gltf_file import GltfFile
from scenes import grey, quad, scene_of

from gpu.errors import UserError
from gpu.scene.objects import Move, numbered, rotation_matrix, with_objects
from gpu.scene.types import Placement, Scene

CHAIR, TABLE = (replace(quad([x, 0, 0], [1, 0, 0], [0, 0, 1]), name=name) for x, name in ((0, "chair"), (3, "table")))


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Two chairs around a table, 4 m wide."""
    other = replace(CHAIR, positions=np.add(CHAIR.positions, (1.5, 0.0, 0.0)))
    return scene_of([CHAIR, TABLE, other], [grey(0.5)])


def test_meshes_of_one_name_are_one_object_and_those_without_vertices_none() -> None:
    used = np.array([True, True, False, False, True, True, True])
    meshes = [(("a",), [0, 0]), (("gone",), [0, 0]), (("b", ""), [0, 1]), (("a",), [0])]
    ids, numbers = numbered(((names, np.array(own)) for names, own in meshes), used)
    assert ids == ("a", "b", "object")
    assert numbers.tolist() == [0, 0, 1, 2, 0]


def test_boxes_are_in_the_world(scene: Scene) -> None:
    assert scene.objects == ("chair", "table")
    low, high = scene.object_boxes
    assert np.allclose(low, [[0, 0, 0], [3, 0, 0]])
    assert np.allclose(high, [[2.5, 0, 1], [4, 0, 1]])
    assert scene.placement == Placement((2.0, 0.0, 0.5), 0.25)
    assert len(replace(scene, objects=(), vertex_object=np.zeros(0, np.int32)).object_boxes[0]) == 0


def test_an_object_is_moved_or_gone_and_the_others_stay(scene: Scene) -> None:
    moved = with_objects(scene, [], {1: Move(offset=(-1.0, 0.0, 0.5))})
    assert np.allclose(moved.object_boxes[0], [[0, 0, 0], [2, 0, 0.5]])
    assert moved.triangles is scene.triangles
    gone = with_objects(scene, [0], {})
    assert gone.vertices is scene.vertices
    assert (gone.vertex_object[gone.triangles] == 1).all()
    assert len(gone.triangles) == len(gone.triangle_material) == 2


def test_an_object_is_turned_about_the_middle_of_its_box_and_its_normals_with_it(scene: Scene) -> None:
    turned = with_objects(scene, [], {0: Move((0.0, 90.0, 0.0), (0.0, 0.5, 0.0)), 1: Move((90.0, 0.0, 0.0))})
    low, high = turned.object_boxes
    assert np.allclose(low, [[0.75, 0.5, -0.75], [3.0, -0.5, 0.5]])
    assert np.allclose(high, [[1.75, 0.5, 1.75], [4.0, 0.5, 0.5]])
    tables = scene.vertex_object == 1
    assert np.allclose(turned.normals[~tables], scene.normals[~tables], atol=1e-6)
    assert np.allclose(turned.normals[tables], scene.normals[tables] @ rotation_matrix((90.0, 0.0, 0.0)).T, atol=1e-6)


def test_an_object_is_made_larger_about_the_middle_of_its_box_before_it_is_turned(scene: Scene) -> None:
    made = with_objects(scene, [], {1: Move((0.0, 90.0, 0.0), (0.0, 0.0, 0.25), 0.5)})
    low, high = made.object_boxes
    assert np.allclose([low[1], high[1]], [[3.25, 0.0, 0.5], [3.75, 0.0, 1.0]])
    assert np.array_equal(low[0], scene.object_boxes[0][0])
    assert made.triangles is scene.triangles
    assert np.allclose(np.linalg.norm(made.normals, axis=1), 1.0)


def test_what_is_made_too_small_to_have_an_area_is_left_out() -> None:
    """As if a file had it so: a quarter of a metre from the middle of a scene of a metre steps are 3e-8 m, and one of
    them is the middle of what is small.
    """
    size = 2.0**-20
    grain = replace(quad([0.75, 0.0, 0.75], [size, 0, 0], [0, 0, size]), name="grain")
    room = scene_of([replace(quad([0, 0, 0], [1, 0, 0], [0, 0, 1]), name="floor"), grain], [grey(0.5)])
    assert len(room.triangles) == 4
    made = with_objects(room, [], {room.objects.index("grain"): Move(scale=0.001)})
    assert (made.vertex_object[made.triangles] == made.objects.index("floor")).all()
    with pytest.raises(UserError, match="nothing that is visible has an area"):
        with_objects(room, [room.objects.index("floor")], {room.objects.index("grain"): Move(scale=0.001)})


def test_rotations_are_about_the_axes_of_the_world_z_first_and_y_last() -> None:
    assert np.allclose(rotation_matrix((90.0, 0.0, 0.0)) @ (0, 1, 0), (0, 0, 1))
    assert np.allclose(rotation_matrix((0.0, 90.0, 0.0)) @ (0, 0, 1), (1, 0, 0))
    assert np.allclose(rotation_matrix((0.0, 0.0, 90.0)) @ (1, 0, 0), (0, 1, 0))
    assert np.allclose(rotation_matrix((90.0, 0.0, 90.0)) @ (1, 0, 0), (0, 0, 1))
    assert np.allclose(rotation_matrix((90.0, 90.0, 0.0)) @ (0, 1, 0), (1, 0, 0))


def test_nodes_of_a_gltf_file_name_objects(tmp_path: object) -> None:
    file = GltfFile(tmp_path)
    primitive = file.primitive(CHAIR.positions, CHAIR.triangles.ravel())
    nodes = [file.mesh_node(primitive, name=name, translation=[x, 0, 0]) for x, name in enumerate(("left", "right"))]
    file.add("scenes", nodes=nodes)
    assert file.load().objects == ("left", "right")

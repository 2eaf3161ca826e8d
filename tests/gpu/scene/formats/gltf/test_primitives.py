import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners, image

from gpu.errors import SceneError
from gpu.scene.formats.gltf.primitives import to_triangles

QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)


def test_strips_and_fans_wind_as_their_first_triangle() -> None:
    indices = np.arange(5)
    assert to_triangles(indices, 5).tolist() == [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
    assert to_triangles(indices, 6).tolist() == [[1, 2, 0], [2, 3, 0], [3, 4, 0]]
    assert to_triangles(indices, 4).tolist() == [[0, 1, 2]]
    assert to_triangles(np.arange(2), 5).shape == (0, 3)


@pytest.mark.parametrize(("mode", "order"), [(4, [0, 1, 2, 0, 2, 3]), (5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])])
def test_each_mode_makes_the_same_quad(gltf: GltfFile, mode: int, order: list[int]) -> None:
    gltf.mesh_node(gltf.primitive(QUAD, order, mode=mode), gltf.primitive(QUAD[order] + (2, 0, 0), mode=mode))
    scene = gltf.load()
    assert len(scene.triangles) == 4
    assert np.allclose(scene.normals, (0, 0, 1))  # flat normals show the winding
    assert np.allclose(corners(scene)[:2].min(axis=(0, 1)), (0, 0, 0))


def test_points_and_lines_are_ignored_and_said_once(gltf: GltfFile) -> None:
    gltf.mesh_node(*(gltf.primitive(mode=mode) for mode in range(5)))
    scene = gltf.load()
    assert len(scene.triangles) == 1
    assert scene.report.ignored == ("points and lines have no surface and were ignored",)


def test_an_incomplete_triangle_is_said(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(TRIANGLE, [0, 1, 2, 0]))
    assert "meshes[0].primitives[0]: ends with an incomplete triangle" in gltf.load().report.ignored[0]


def test_an_index_out_of_range(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(TRIANGLE, [0, 1, 3]))
    with pytest.raises(SceneError, match=r"meshes\[0\]\.primitives\[0\]: index 2 is 3, there are 3 vertices"):
        gltf.load()


@pytest.mark.parametrize(
    ("normals", "says"),
    [(QUAD, "NORMAL has 4 elements, POSITION 3"), (TRIANGLE[:0], "NORMAL has 0 elements"), (99, "99 does not exist")],
)
def test_a_broken_attribute_is_left_out(gltf: GltfFile, normals: np.ndarray | int, says: str) -> None:
    gltf.mesh_node(gltf.primitive(TRIANGLE, NORMAL=normals))
    scene = gltf.load()
    assert np.allclose(scene.normals, (0, 0, 1))
    assert says in scene.report.ignored[0]
    assert scene.report.ignored[0].endswith("; NORMAL was left out")


@pytest.mark.parametrize("broken", [{"attributes": {}}, {"attributes": {"NORMAL": 0}}, {}])
def test_a_primitive_without_positions_is_left_out(gltf: GltfFile, broken: dict) -> None:
    gltf.mesh_node(gltf.primitive(), broken)
    assert gltf.load().report.ignored == ("meshes[0].primitives[1]: has no positions and was left out",)


@pytest.mark.parametrize("indices", [[], [0, 1]])
def test_a_primitive_without_triangles_is_left_out(gltf: GltfFile, indices: list[int]) -> None:
    gltf.mesh_node(gltf.primitive(), gltf.primitive(TRIANGLE, indices, mode=5))
    scene = gltf.load()
    assert len(scene.triangles) == 1
    assert scene.report.ignored == ("meshes[0].primitives[1]: has no triangles and was left out",)


def test_accessors_without_elements_make_a_primitive_without_triangles(gltf: GltfFile) -> None:
    empty = gltf.add("accessors", componentType=5126, count=0, type="VEC3", bufferView=99)
    gltf.mesh_node(gltf.primitive(), gltf.primitive(empty))
    assert gltf.load().report.ignored == ("meshes[0].primitives[1]: has no triangles and was left out",)


NAN = np.nan


@pytest.mark.parametrize(
    ("name", "rows", "says"),
    [
        ("NORMAL", [[0, 0, 1], [NAN, 0, 1], [0, 0, 1]], "1 of 3 are not finite: geometric normals were used"),
        ("NORMAL", [[0, 0, 1], [0, 0, np.inf], [0, 0, -np.inf]], "2 of 3 are not finite"),
        ("TEXCOORD_0", [[0, 0], [NAN, 1], [1, 1]], "1 of 3 are not finite: 0 was used"),
        ("COLOR_0", [[1, 1, 1], [1, NAN, 0], [1, 1, 1]], "1 of 3 are not finite: white was used"),
        ("COLOR_0", [[1, 1, 1], [2, 1, -1], [1, 1, 1]], "colours outside 0 to 1"),
    ],
)
def test_odd_numbers_of_attributes_are_mended(gltf: GltfFile, name: str, rows: list, says: str) -> None:
    gltf.add("textures", source=image(gltf))
    gltf.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    uvs = {} if name == "TEXCOORD_0" else {"TEXCOORD_0": TRIANGLE[:, :2]}
    gltf.mesh_node(gltf.primitive(material=0, **{name: np.float32(rows)}, **uvs))
    scene = gltf.load()
    assert np.allclose(scene.normals, (0, 0, 1))
    assert np.isfinite(scene.uvs).all()
    assert scene.colors is None or (
        np.isfinite(scene.colors).all() and 0 <= scene.colors.min() <= scene.colors.max() <= 1
    )
    assert any(
        note.startswith(f"meshes[0].primitives[0].attributes.{name}: ") and says in note for note in scene.report.notes
    )


def test_a_broken_morph_target_is_left_out(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(targets=[{"POSITION": 77}, 5]), mesh={"weights": [1.0, "x", 3]})
    scene = gltf.load()
    assert np.array_equal(corners(scene), [TRIANGLE])
    assert (
        "targets[0].POSITION: 77 does not exist, there are 1; the morph target was left out" in scene.report.ignored[0]
    )
    assert any("meshes[0].weights[1]" in note for note in scene.report.notes)


def test_quantised_positions_and_normals(gltf: GltfFile) -> None:
    gltf.json["extensionsUsed"] = gltf.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    positions = gltf.accessor(TRIANGLE.astype(np.int16) * 100)
    normals = gltf.accessor(np.tile(np.array([0, 0, 127], np.int8), (3, 1)), normalized=True)
    uvs = gltf.accessor(np.array([[0, 0], [255, 0], [0, 255]], np.uint8), normalized=True)
    gltf.add("images", uri="data:image/png;base64,")
    gltf.mesh_node(gltf.primitive(positions, NORMAL=normals, TEXCOORD_0=uvs), scale=[0.01, 0.01, 0.01])
    scene = gltf.load()
    assert np.array_equal(corners(scene), [TRIANGLE])
    assert np.array_equal(scene.normals, np.tile([0.0, 0.0, 1.0], (3, 1)))


@pytest.mark.parametrize("where", ["mesh", "node"])
def test_morph_targets_are_applied_at_their_weights(gltf: GltfFile, where: str) -> None:
    shift = gltf.accessor(np.array([[0, 0, 0], [2, 0, 0], [0, 4, 0]], np.float32))
    primitive = gltf.primitive(targets=[{"POSITION": shift}])
    weights = {"weights": [0.5]}
    gltf.mesh_node(primitive, mesh=weights if where == "mesh" else None, **(weights if where == "node" else {}))
    assert np.array_equal(corners(gltf.load()), [[[0, 0, 0], [2, 0, 0], [0, 3, 0]]])


@pytest.mark.parametrize(
    ("colors", "normalized"),
    [
        (np.array([[1, 0.5, 0]] * 3, np.float32), False),
        (np.array([[1, 0.5, 0, 1]] * 3, np.float32), False),
        (np.array([[255, 128, 0]] * 3, np.uint8), True),
        (np.array([[65535, 32768, 0, 65535]] * 3, np.uint16), True),
    ],
)
def test_vertex_colours(gltf: GltfFile, colors: np.ndarray, normalized: bool) -> None:
    gltf.mesh_node(gltf.primitive(COLOR_0=gltf.accessor(colors, normalized=normalized)), gltf.primitive(TRIANGLE + 1))
    scene = gltf.load()
    assert scene.colors is not None
    assert np.allclose(scene.colors[:3], (1, 0.5, 0, 1), atol=0.002)
    assert np.array_equal(scene.colors[3:], np.ones((3, 4)))  # where a mesh has none, it is white

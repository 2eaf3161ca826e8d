from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.formats.gltf.writing import glb_of
from gpu.scene.formats.obj import load_obj
from gpu.scene.formats.obj.statements import MOST_OBJECTS
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.load import load_scene
from gpu.scene.types import Scene


def load(folder: Path, text: str, mtl: str | None = None) -> Scene:
    (folder / "scene.obj").write_text(text)
    if mtl is not None:
        (folder / "scene.mtl").write_text(mtl)
    return load_obj(folder / "scene.obj", DEFAULT_LIMITS)


def corners(scene: Scene) -> np.ndarray:
    world = scene.vertices / scene.placement.scale + scene.placement.centre
    return np.round(world[scene.triangles], 5)


def test_negative_indices_count_back_from_their_own_line(tmp_path: Path) -> None:
    scene = load(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\nf 1 2 -1\n")
    assert corners(scene)[:, :, 0].tolist() == [[0, 1, 0], [5, 6, 5], [0, 1, 5]]


def test_polygons_of_any_size_and_all_forms_of_corners(tmp_path: Path) -> None:
    scene = load(
        tmp_path,
        "v 0 0 0 # a comment\nv 2 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nvt 0 0.25\nvt 1 0 0\nvn 0 0 1\n"
        "f 1/1/1 2/2/1 3//1 4/1 5\nf 1 2 \\\n 3\nl 1 2\n",
    )
    assert len(scene.triangles) == 4
    assert np.allclose(scene.normals, (0, 0, 1))
    assert scene.report.ignored == ("points and lines have no surface and were ignored",)


def test_materials_and_textures(tmp_path: Path) -> None:
    Image.new("RGB", (1, 1), (255, 0, 0)).save(tmp_path / "red brick.png")
    scene = load(
        tmp_path,
        "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0\nvt 0 1\n"
        "usemtl lamp\nf 1/1 2/2 3/3\nusemtl wall one\nf 1/1 3/3 2/2\nusemtl none\nf 3 2 1\n",
        "# a library\nnewmtl wall one\nKd 0.5 0.5 0.5\nmap_Kd red brick.png\ndisp d.png\nNs 6\n"
        "newmtl lamp\nKd 0.1 0.2 0.3\nKe 7 8 9\nKs 1 1 1\n",
    )
    lamp, wall, none = (scene.materials[number] for number in scene.triangle_material[np.argsort(
        scene.triangle_material)])  # fmt: skip
    assert (lamp.name, lamp.base_color, lamp.emission, lamp.specular) == ("lamp", (0.1, 0.2, 0.3, 1), (7, 8, 9), 1.0)
    assert (wall.base_color, wall.roughness, wall.specular) == ((1, 1, 1, 1), 0.25**0.25, 0.0)
    assert wall.base_color_slot is not None
    assert scene.textures[wall.base_color_slot.texture].pixels.tolist() == [[[255, 0, 0, 255]]]
    assert none.base_color == (0.8, 0.8, 0.8, 1.0)
    first = scene.triangles[scene.triangle_material == 0][0]
    assert np.allclose(scene.uvs[0][first], [[0, 0.75], [1, 1], [0, 0]])  # v = 0 is the bottom in OBJ
    assert set(scene.report.ignored) == {
        "material none is not defined: its surfaces are grey",
        "disp of MTL materials is not supported and was ignored",
    }


@pytest.mark.parametrize(
    ("text", "mtl", "says"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", None, "line 3: v: is not finite"),
        ("v 0 0\n", None, "line 1: v needs 3 numbers"),
        ("v 0,5 0 0\n", None, "line 1: v needs 3 numbers, with points for decimals"),
        ("\n\tV\t0 0 z\n", None, "line 2: v needs 3 numbers"),
        ("v 0 0 0\nv 1 0 0\nf 1 2 3\n", None, "line 3: v index '3' does not exist, there are 2"),
        ("v 0 0 0\nf 1/2 1 1\nf 1/3 1 1\nvt 0 0\n", None, "line 2: vt index '2' does not exist, there are 1"),
        ("v 0 0 0\nf 0 1 1\n", None, "line 2: v index '0'"),
        ("v 0 0 0\nf -2 1 1\n", None, "line 2: v index '-2'"),
        ("v 0 0 0\nf 1/1 1 1\n", None, "line 2: vt index '1'"),
        ("v 0 0 0\nf 1.5 1 1\n", None, "line 2: v index '1.5'"),
        ("v 0 0 0\nf 1 1 9999999999999999\n", None, "line 2: v index '9999999999999999' does not exist"),
        ("v 0 0 0\nf 1 1 1_0\n", None, "line 2: v index '1_0' does not exist"),
        ("v 0 0 0\nf 1 1\n", None, "no triangles"),
        ("v 0 0 0\n", None, "no triangles"),
        ("", None, "no triangles"),
        ("mtllib ../scene.mtl\n", None, "mtllib: '../scene.mtl' is outside"),
    ],
)
def test_what_is_broken_is_named_by_its_line(tmp_path: Path, text: str, mtl: str | None, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, text, mtl)
    assert says in str(caught.value)
    assert "scene.obj" in str(caught.value)


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    "text",
    [
        TRIANGLE + "f 1 2 3",
        "\tv\t0\t0 0\nv  1   0\f0\nv 0 1 0\n f\t1  2\t3 ",
        (TRIANGLE + "f 1 2 3").replace("\n", "\r"),
        (TRIANGLE + "f 1 2 3").replace("\n", "\r\n"),
        (TRIANGLE + "f 1 2 3").upper(),
        "f 1 2 3\n" + TRIANGLE,
        "\ufeff" + TRIANGLE + "f 1// 2/ 3 # a face",
        "v 0 0 \\ \n0 # first\nv 1 0 0 1.0\nv 0 1 0\nf 1\\\n2 3\n",
    ],
)
def test_any_white_space_splits(tmp_path: Path, text: str) -> None:
    scene = load(tmp_path, text)
    assert corners(scene).tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
    assert scene.report.ignored == ()


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_names_are_found_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "wände.mtl").write_bytes("newmtl grün\nKd 0 1 0\n".encode())
    (tmp_path / "scene.obj").write_bytes(f"mtllib wände.mtl\n{TRIANGLE}usemtl grün\nf 1 2 3\n".encode(encoding))
    (green,) = load_obj(tmp_path / "scene.obj", DEFAULT_LIMITS).materials
    assert green.base_color == (0, 1, 0, 1)


def test_concave_polygons_keep_their_shape_and_what_their_corners_have(tmp_path: Path) -> None:
    scene = load(
        tmp_path,
        "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nvt 0 0\nvt 1 0\nvt 0.25 0.25\nvt 0 1\nf 4/4 1/1 2/2 3/3\n",
    )
    edges = corners(scene)
    areas = np.linalg.norm(np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1) / 2.0
    assert areas.sum() == pytest.approx(4.0)
    assert np.allclose(scene.uvs[0][scene.triangles] * (4, -4) + (0, 4), edges[:, :, :2])


def test_colours_of_vertices_are_encoded_as_displays_show_them(tmp_path: Path) -> None:
    scene = load(tmp_path, "v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0 nan 0 0\nf 1 2 3\n")
    assert scene.colors is not None
    assert np.allclose(scene.colors[scene.triangles[0]], [(1, 1, 1, 1), (1, 0.214, 0, 1), (1, 1, 1, 1)], atol=1e-3)
    assert scene.materials[0].base_color == (1, 1, 1, 1)
    assert scene.report.ignored == ("colours that are not finite numbers were taken as white (1)",)


def test_a_smoothing_group_shares_normals_and_none_has_its_own(tmp_path: Path) -> None:
    roof = "v 0 0 0\nv 0 0 1\nv 1 1 0\nv 1 1 1\nv 2 0 0\nv 2 0 1\n{}\nf 1 2 4 3\nf 3 4 6 5\n"
    for statement, up in (("s 1", 1.0), ("s on", 1.0), ("s off", 0.5**0.5), ("s 0", 0.5**0.5), ("", 0.5**0.5)):
        scene = load(tmp_path, roof.format(statement))
        ridge = np.isclose(scene.vertices[:, 1], scene.vertices[:, 1].max())
        assert np.allclose(scene.normals[ridge, 1], up)
    assert np.allclose(load(tmp_path, roof.format("s 1").replace("f 3", "s 2\nf 3")).normals[:, 1], 0.5**0.5)


def test_what_is_broken_beside_the_geometry_is_left_out_with_a_sentence(tmp_path: Path) -> None:
    scene = load(
        tmp_path,
        TRIANGLE + "v nan 0 0\nv 1.#QNAN 0 0\nv 1e200 0 0\nvt x\nvt nan 0\nvt 1 1\nvn 0 0\nvn 0 0 nan\nvn 0 0 1\n"
        "f 1/1/1 2/2/2 3/3/3\nf 1 2\ncurv 1\n",
    )
    assert np.allclose(scene.normals, (0, 0, 1))
    first = scene.triangles[scene.triangle_material == 0][0]
    assert np.allclose(scene.uvs[0][first], [(0, 1), (0, 1), (1, 0)])
    said = " ".join(scene.report.ignored)
    for sentence in (
        "line 7: vt is not 2 numbers",
        "line 10: vn is not 3 numbers",
        "line 14: a face with fewer than 3 corners was left out",
        "normals that are not finite: the geometric ones were taken (2)",
        "texture coordinates that are not finite: 0 0 was taken (2)",
        "vertices that no face uses are not finite or too far away and were left out (3)",
        "statement 'curv'",
    ):
        assert sentence in said


ROOM = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood\nf 1 2 3\n"


@pytest.mark.parametrize(
    ("text", "objects"),
    [
        (ROOM + "usemtl iron\nf 1 2 3\n", ("wood", "iron")),
        ("f 1 2 3\no Chair\n" + ROOM + "usemtl iron\nf 1 2 3\no Table\nf 1 2 3\n", ("default", "Chair", "Table")),
        ("g default\n" + ROOM + "g Seat  Leg\nusemtl iron\nf 1 2 3\n", ("default", "Seat Leg")),
    ],
)
def test_names_are_objects_and_where_there_are_none_materials(
    tmp_path: Path, text: str, objects: tuple[str, ...]
) -> None:
    scene = load(tmp_path, text)
    assert scene.objects == objects
    (tmp_path / "again.glb").write_bytes(glb_of(scene))
    assert load_scene(tmp_path / "again.glb").objects == objects


def test_an_object_has_all_its_materials(tmp_path: Path) -> None:
    scene = load(tmp_path, "o Chair\n" + ROOM + "usemtl iron\nf 1 2 3\no Table\nf 1 2 3\no Chair\nf 1 2 3\n")
    owners = scene.vertex_object[scene.triangles]
    assert (owners == owners[:, :1]).all()
    chair = owners[:, 0] == scene.objects.index("Chair")
    names = [scene.materials[number].name for number in scene.triangle_material]
    assert sorted(zip(chair.tolist(), names, strict=True)) == [
        (False, "iron"), (True, "iron"), (True, "iron"), (True, "wood"),
    ]  # fmt: skip


def test_groups_of_a_few_faces_each_are_no_objects(tmp_path: Path) -> None:
    scene = load(tmp_path, ROOM + "".join(f"g {number}\nf 1 2 3\n" for number in range(MOST_OBJECTS)))
    assert scene.objects == ("wood",)
    assert "has more than 10,000 names of objects or groups: its materials are its objects" in scene.report.ignored

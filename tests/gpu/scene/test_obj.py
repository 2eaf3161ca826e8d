from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.obj import load_obj
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
        "# a library\nnewmtl wall one\nKd 0.5 0.5 0.5\nmap_Kd red brick.png\nd 0.5\nNs 6\n"
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
        "d of MTL materials is not supported and was ignored",
    }


@pytest.mark.parametrize(
    ("text", "mtl", "says"),
    [
        ("v 0 0 nan\n", None, "line 1: v needs 3 finite numbers"),
        ("v 0 0\n", None, "line 1: v needs 3 finite numbers"),
        ("vt one\n", None, "line 1: vt needs 1 finite numbers"),
        ("v 0 0 0\nv 1 0 0\nf 1 2 3\n", None, "line 3: v index '3' does not exist, so far 2"),
        ("v 0 0 0\nf 0 1 1\n", None, "line 2: v index '0'"),
        ("v 0 0 0\nf -2 1 1\n", None, "line 2: v index '-2'"),
        ("v 0 0 0\nf 1/1 1 1\n", None, "line 2: vt index '1'"),
        ("v 0 0 0\nf 1 1\n", None, "line 2: a face needs at least 3 corners"),
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

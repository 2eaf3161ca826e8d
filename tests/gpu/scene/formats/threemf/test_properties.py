import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from threemf_file import mesh, model, threemf

from gpu.errors import SceneError
from gpu.scene.formats.threemf import load_threemf
from gpu.scene.types import AlphaMode, Scene, Wrap

BASES = (
    '<basematerials id="5"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#00BC0080"/>'
    '<base name="c" displaycolor="red"/></basematerials>'
)
COLORS = '<m:colorgroup id="6"><m:color color="#FF0000"/><m:color color="#0000FF80"/></m:colorgroup>'
MIXES = (
    '<m:compositematerials id="7" matid="5" matindices="0 1"><m:composite values="1 0"/><m:composite values="1 1"/>'
    "</m:compositematerials>"
)
LAYERS = '<m:multiproperties id="8" pids="5 6"><m:multi pindices="1 0"/><m:multi pindices="0 0"/></m:multiproperties>'
IMAGE = (
    '<m:texture2d id="9" path="/3D/Textures/t.png" contenttype="image/png" tilestyleu="mirror"/>'
    '<m:texture2dgroup id="10" texid="9"><m:tex2coord u="0" v="1"/><m:tex2coord u="0" v="0"/></m:texture2dgroup>'
)


def load(folder: Path, resources: str, group: int, image: bytes = b"") -> Scene:
    """The first triangle has entries 0, 1, 1 of `group`, the others entry 1."""
    triangles = (f'pid="{group}" p1="0" p2="1" p3="1"', *(f'pid="{group}" p1="1"',) * 3)
    body = f'<object id="1">{mesh(10.0, triangles)}</object>'
    others = {"3D/Textures/t.png": image} if image else {}
    (folder / "a.3mf").write_bytes(threemf(model(resources + body), others))
    return load_threemf(folder / "a.3mf")


def test_base_materials(tmp_path: Path) -> None:
    scene = load(tmp_path, BASES, 5)
    red, green = scene.materials
    assert (red.name, red.base_color, red.alpha_mode) == ("a", (1, 0, 0, 1), AlphaMode.OPAQUE)
    assert green.base_color == pytest.approx((0, 0.5029, 0, 128 / 255), abs=1e-4)
    assert green.alpha_mode is AlphaMode.BLEND
    assert sorted(scene.triangle_material) == [0, 1, 1, 1]


def test_a_colour_that_is_none_is_said(tmp_path: Path) -> None:
    scene = load(tmp_path, BASES.replace("#00BC0080", "#00BC0"), 5)
    assert "group 5: a colour that is not #RRGGBB or #RRGGBBAA was taken as grey" in scene.report.ignored


def test_colours_of_corners(tmp_path: Path) -> None:
    scene = load(tmp_path, COLORS, 6)
    assert scene.colors is not None
    of_first = scene.colors[scene.triangles[0]]
    np.testing.assert_allclose(of_first, [[1, 0, 0, 1], *[[0, 0, 1, 128 / 255]] * 2], atol=1e-6)
    assert scene.materials[0].alpha_mode is AlphaMode.BLEND


def test_mixes_of_base_materials(tmp_path: Path) -> None:
    scene = load(tmp_path, BASES + MIXES, 7)
    assert scene.colors is not None
    np.testing.assert_allclose(scene.colors[scene.triangles[1]][0], [0.5, 0.2515, 0, 0.751], atol=1e-3)


def test_of_layers_the_first_is_shown(tmp_path: Path) -> None:
    scene = load(tmp_path, BASES + COLORS + LAYERS, 8)
    assert sorted(scene.materials[number].name for number in scene.triangle_material) == ["a", "a", "a", "b"]
    assert "group 8: of properties in layers the first is shown" in scene.report.ignored


def test_a_texture_stands_upright(tmp_path: Path) -> None:
    written = io.BytesIO()
    Image.fromarray(np.array([[[255, 0, 0]], [[0, 0, 255]]], np.uint8)).save(written, "PNG")
    scene = load(tmp_path, IMAGE, 10, written.getvalue())
    (texture,), (material,) = scene.textures, scene.materials
    assert (texture.wrap_s, texture.wrap_t, material.base_color) == (Wrap.MIRROR, Wrap.REPEAT, (1, 1, 1, 1))
    assert scene.uvs[0][scene.triangles[0]].tolist() == [[0, 0], [0, 1], [0, 1]]
    assert texture.pixels[0, 0, 0] == 255


@pytest.mark.parametrize(("image", "says"), [(b"", "is missing in the package"), (b"x", "was left out: not an image")])
def test_a_texture_that_cannot_be_read_is_said(tmp_path: Path, image: bytes, says: str) -> None:
    scene = load(tmp_path, IMAGE, 10, image)
    assert scene.materials[0].base_color == (0.8, 0.8, 0.8, 1.0)
    assert any(says in said for said in scene.report.ignored)


@pytest.mark.parametrize(
    ("resources", "group", "says"),
    [
        (BASES + MIXES.replace('"0 1"', '"0 9"'), 7, "group 7: its mixes cannot be read: there is no base material 9"),
        (BASES + MIXES.replace('"1 1"', '"1"'), 7, "its mixes cannot be read"),
        (BASES + MIXES.replace('"1 1"', '"1 INF"'), 7, "shares are numbers of 0 to 1"),
        (IMAGE.replace('v="0"', ""), 10, "group 10: its coordinates"),
    ],
)
def test_what_is_broken_is_refused(tmp_path: Path, resources: str, group: int, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        load(tmp_path, resources, group)

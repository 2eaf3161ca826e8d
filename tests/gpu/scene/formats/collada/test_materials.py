import io
from pathlib import Path

import numpy as np
import pytest
from dae_file import BOUND, TEXTURE, UVS, dae, effect, geometry, source, use
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.formats.collada import load_collada
from gpu.scene.types import AlphaMode, Scene

MESH = geometry(
    surface="<polylist><vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>",
    sources=source("u", UVS, "ST"),
    inputs='<input semantic="TEXCOORD" source="#u" offset="1" set="0"/>',
)
MAP = '<texture texture="t" texcoord="UV"/>'


def png() -> bytes:
    """Red above, blue and half transparent below."""
    written = io.BytesIO()
    Image.fromarray(np.array([[[255, 0, 0, 255]], [[0, 0, 255, 100]]], np.uint8)).save(written, "PNG")
    return written.getvalue()


def load(folder: Path, shader: str, init: str = "<init_from>a.png</init_from>", params: str = TEXTURE) -> Scene:
    images = f'<library_images><image id="i" name="pic">{init}</image></library_images>'
    content = dae([f"<node>{use(bound=BOUND)}</node>"], MESH, images + effect(shader, params))
    (folder / "a.dae").write_bytes(content)
    return load_collada(folder / "a.dae")


def test_a_phong_material(tmp_path: Path) -> None:
    shader = (
        "<phong><emission><color>0 2 0 1</color></emission><diffuse><color>0.5 1.5 0 1</color></diffuse>"
        "<specular><color>1 1 1 1</color></specular><shininess><float>30</float></shininess>"
        "<index_of_refraction><float>1.4</float></index_of_refraction></phong>"
    )
    (material,) = load(tmp_path, shader).materials
    assert material.name == "Red"
    assert material.base_color == pytest.approx((0.21404, 1, 0, 1), abs=1e-4)
    assert (material.emission, material.specular, material.ior) == ((0, 2, 0), 1.0, 1.4)
    assert material.roughness == pytest.approx(0.5)


@pytest.mark.parametrize("shader", ["<lambert/>", "<constant><emission><color>0 0 1 1</color></emission></constant>"])
def test_others(tmp_path: Path, shader: str) -> None:
    (material,) = load(tmp_path, shader).materials
    assert (material.specular, material.unlit, material.emission) == (0.0, "constant" in shader, (0, 0, 0))


@pytest.mark.parametrize(
    "init", ["<init_from>a.png</init_from>", "<init_from><ref>./a.png</ref></init_from>", "<data>{}</data>",
             "<init_from>file:///C:/old/A.PNG</init_from>"]
)  # fmt: skip
def test_a_texture_stands_upright(tmp_path: Path, init: str) -> None:
    (tmp_path / "a.png").write_bytes(png())
    scene = load(tmp_path, f"<lambert><diffuse>{MAP}</diffuse></lambert>", init.format(png().hex()))
    (texture,), (material,) = scene.textures, scene.materials
    assert texture.srgb
    assert (material.base_color, material.alpha_mode) == ((1, 1, 1, 1), AlphaMode.OPAQUE)
    highest = scene.vertices[:, 2].argmin()  # Y of the file, 2 m from its lower edge
    assert texture.pixels[round(float(scene.uvs[0, highest, 1])), 0, 0] == 255


def test_the_alpha_of_a_texture_counts_where_it_is_said(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png())
    scene = load(tmp_path, f"<lambert><diffuse>{MAP}</diffuse><transparent>{MAP}</transparent></lambert>")
    assert scene.materials[0].alpha_mode is AlphaMode.BLEND


@pytest.mark.parametrize(
    ("init", "says"), [("<init_from>b.png</init_from>", "image pic: the texture was left out: 'b.png' does not exist"),
                       ("<data>xy</data>", "broken data")]
)  # fmt: skip
def test_a_missing_texture_is_said(tmp_path: Path, init: str, says: str) -> None:
    scene = load(tmp_path, f"<lambert><diffuse>{MAP}</diffuse></lambert>", init)
    assert scene.textures == ()
    assert any(says in said for said in scene.report.ignored)


def test_a_texture_outside_the_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="outside the scene's folder"):
        load(tmp_path, f"<lambert><diffuse>{MAP}</diffuse></lambert>", "<init_from>../a.png</init_from>")


def test_what_nothing_is_bound_to_is_grey_and_said(tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_bytes(dae(geometries=geometry(material="wood")))
    scene = load_collada(tmp_path / "a.dae")
    assert scene.materials[0].base_color == (0.8, 0.8, 0.8, 1.0)
    assert scene.report.ignored == ("'wood': a material that nothing is bound to: its surfaces are grey",)

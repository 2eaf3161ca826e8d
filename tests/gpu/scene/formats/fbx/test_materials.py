from pathlib import Path

import numpy as np
import pytest
from fbx_file import FbxFile
from PIL import Image

from gpu.scene.formats.fbx import load_fbx
from gpu.scene.formats.fbx.extracted import Extracted
from gpu.scene.formats.fbx.materials import Materials
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.types import AlphaMode, Material, Scene

pytest.importorskip("ufbx")


@pytest.fixture(scope="module")
def things(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """Squares of several materials, with files of textures beside the scene and in a folder."""
    fbx = FbxFile(tmp_path_factory.mktemp("fbx"))
    (fbx.folder / "tex").mkdir()
    for name in ("tex/a.png", "b.png"):
        Image.fromarray(np.full((1, 1, 3), (10, 20, 30), np.uint8)).save(fbx.folder / name)
    (fbx.folder / "broken.png").write_bytes(b"no image")
    files = {
        "Relative": ("C:\\else\\a.png", "tex\\a.png"),
        "Absolute": ("C:\\else\\b.png", "..\\b.png"),
        "End": ("C:\\else\\tex\\a.png", "..\\job\\Tex\\a.png"),
        "Missing": ("C:\\else\\none.png", "none.png"),
        "Broken": ("broken.png", "broken.png"),
    }
    for name in (*files, "Phong", "Clear", "None"):
        node = fbx.node(name, "Mesh")
        fbx.mesh(node)
        if name == "Phong":
            fbx.material(
                node, name, DiffuseColor=(0.5, 0.25, 0.125), EmissiveColor=(1.0, 2.0, 3.0), ShininessExponent=50.0
            )
        elif name == "Clear":
            fbx.material(
                node, name, TransparencyFactor=0.75, TransparentColor=(1.0, 1.0, 1.0), SpecularColor=(0.0, 0.0, 0.0)
            )
        elif name != "None":
            fbx.texture(
                fbx.material(node, name, DiffuseColor=(0.5, 0.5, 0.5)), *files[name][:1], relative=files[name][1]
            )
    return load_fbx(fbx.write())


def named(scene: Scene, name: str) -> Material:
    return next(material for material in scene.materials if material.name == name)


@pytest.mark.parametrize("name", ["Relative", "Absolute", "End"])
def test_textures_beside_the_scene(things: Scene, name: str) -> None:
    material = named(things, name)
    assert things.textures[material.base_color_slot.texture].pixels[0, 0].tolist() == [10, 20, 30, 255]
    assert material.base_color == (1.0, 1.0, 1.0, 1.0)


def test_textures_that_cannot_be_read_are_said(things: Scene) -> None:
    assert named(things, "Missing").base_color_slot is None
    assert named(things, "Missing").base_color[:3] == pytest.approx((0.5, 0.5, 0.5))
    assert "none.png: the texture's file is missing" in things.report.ignored
    assert any(sentence.startswith("broken.png: not an image") for sentence in things.report.ignored)


def test_phong(things: Scene) -> None:
    material = named(things, "Phong")
    assert material.base_color == pytest.approx((0.5, 0.25, 0.125, 1.0))
    assert material.emission == pytest.approx((1.0, 2.0, 3.0))
    assert 0.2 < material.roughness < 0.5
    assert material.specular == 1.0
    assert material.double_sided is None


def test_transparency(things: Scene) -> None:
    material = named(things, "Clear")
    assert material.base_color[3] == pytest.approx(0.25)
    assert material.alpha_mode is AlphaMode.BLEND
    assert material.specular == 0.0


def test_without_a_material(things: Scene) -> None:
    assert named(things, "default").base_color == (0.8, 0.8, 0.8, 1.0)


def test_coordinates_count_from_the_top(things: Scene) -> None:
    low = things.vertices[:, 1] == things.vertices[:, 1].min()
    assert np.allclose(things.uvs[0][low][:, 1], 1.0)


EVERY = (
    *("base_factor", "base_color", "roughness", "glossiness", "metalness", "specular_factor", "specular_color"),
    *("specular_ior", "emission_factor", "emission_color", "opacity", "transmission_factor", "transmission_color"),
    "normal_map",
)


def surface(folder: Path, classic: bool = False, **textures: str) -> tuple[Material, Materials]:
    """A material of roughness 0.25 and metalness 0.5 with these textures, files of the folder."""
    names = sorted(set(textures.values()))
    told = {name: {"value": None, "texture": None} for name in EVERY}
    told["roughness"]["value"], told["metalness"]["value"] = (0.25,), (0.5,)
    for name, file in textures.items():
        told[name]["texture"] = names.index(file)
    entries = [
        {"file": True, "names": [name, "", ""], "clamped": [True, False], "transform": np.eye(4)[:, :3].tolist()}
        for name in names
    ]
    arrays = {f"texture{number}": np.empty(0, np.uint8) for number in range(len(names))}
    material = {"name": "M", "double_sided": False, "classic": classic, **told}
    found = Extracted(folder / "a.fbx", DEFAULT_LIMITS, {"materials": [material], "textures": entries}, arrays)
    made = Materials(found)
    return made.materials[made.number(0)], made


@pytest.fixture
def maps(tmp_path: Path) -> Path:
    for name, size, level in (("rough.png", (2, 2), 60), ("metal.png", (1, 1), 200)):
        Image.fromarray(np.full((*size, 3), (level, 9, 9), np.uint8)).save(tmp_path / name)
    return tmp_path


@pytest.mark.parametrize(
    ("textures", "texel", "factors"),
    [
        ({"roughness": "rough.png"}, [255, 60, 255], (1.0, 0.5)),
        ({"glossiness": "rough.png"}, [255, 195, 255], (1.0, 0.5)),
        ({"metalness": "metal.png"}, [255, 255, 200], (0.25, 1.0)),
        ({"roughness": "rough.png", "metalness": "metal.png"}, [255, 60, 200], (1.0, 1.0)),
        ({"roughness": "none.png", "metalness": "metal.png"}, [255, 255, 200], (0.25, 1.0)),
    ],
)
def test_roughness_and_metalness_of_textures(
    maps: Path, textures: dict[str, str], texel: list[int], factors: tuple[float, float]
) -> None:
    material, made = surface(maps, **textures)
    assert material.metallic_roughness_slot is not None
    texture = made.textures[material.metallic_roughness_slot.texture]
    assert texture.pixels[0, 0, :3].tolist() == texel
    assert texture.srgb is False
    assert (material.roughness, material.metallic) == factors


def test_maps_of_a_phong_shader_are_no_roughness_and_are_said(maps: Path) -> None:
    material, made = surface(maps, classic=True, roughness="rough.png", metalness="metal.png")
    assert material.metallic_roughness_slot is None
    assert (material.roughness, material.metallic) == (0.25, 0.5)
    assert made.found.remarks.sentences() == (
        "M: textures of roughness are not shown",
        "M: textures of metalness are not shown",
    )

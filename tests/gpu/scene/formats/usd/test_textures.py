import numpy as np
import pytest
from usd_file import UsdFile

from gpu.errors import SceneError
from gpu.scene.formats.usd import load_usd
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Wrap

pytest.importorskip("pxr")
from pxr import Sdf, UsdUtils


def colored(usd: UsdFile, file: str, **inputs: object) -> None:
    usd.material(usd.mesh(), diffuseColor=(usd.texture("/T", file, **inputs), "rgb"))


def test_wrap_modes(usd: UsdFile) -> None:
    colored(usd, usd.image("a.png", [[(1, 2, 3)]]), wrapS="clamp", wrapT="mirror")
    texture = usd.load().textures[0]
    assert (texture.wrap_s, texture.wrap_t, texture.name) == (Wrap.CLAMP, Wrap.MIRROR, "a.png")


def test_black_outside_is_said(usd: UsdFile) -> None:
    colored(usd, usd.image("a.png", [[(1, 2, 3)]]), wrapS="black")
    scene = usd.load()
    assert (scene.textures[0].wrap_s, scene.textures[0].wrap_t) == (Wrap.CLAMP, Wrap.REPEAT)
    assert "textures cannot be 'black' outside their edges: clamped instead" in scene.report.ignored


@pytest.mark.parametrize(("space", "srgb"), [("raw", False), ("sRGB", True), ("auto", True)])
def test_colour_spaces(usd: UsdFile, space: str, srgb: bool) -> None:
    colored(usd, usd.image("a.png", [[(1, 2, 3)]]), sourceColorSpace=space)
    assert usd.load().textures[0].srgb == srgb


def test_transforms_of_coordinates(usd: UsdFile) -> None:
    mesh = usd.mesh()
    st = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    usd.primvar(mesh, "st", "TexCoord2fArray", "vertex", st)
    reader = usd.shader("/Reader", "UsdPrimvarReader_float2", varname="st")
    place = usd.shader("/Place", "UsdTransform2d", rotation=90.0, scale=(2.0, 3.0), translation=(0.5, 0.25))
    place.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(
        reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    )
    texture = usd.texture("/T", usd.image("a.png", [[(1, 2, 3)]]), st=(place, "result"))
    usd.material(mesh, diffuseColor=(texture, "rgb"))
    scene = usd.load()
    a, b, c, d, e, f = scene.materials[0].base_color_slot.transform
    uvs = scene.uvs[0] @ np.array([[a, d], [b, e]]) + (c, f)
    u, v = np.array(st).T
    expected = np.stack([-3.0 * v + 0.5, 1.0 - (2.0 * u + 0.25)], axis=1)
    order = np.lexsort(uvs.round(4).T)
    assert np.allclose(np.unique(uvs.round(4), axis=0), np.unique(expected.round(4), axis=0)), uvs[order]


def test_one_file_is_one_texture(usd: UsdFile) -> None:
    file = usd.image("a.png", [[(1, 2, 3)]])
    for number in range(2):
        usd.material(usd.mesh(f"/M{number}"), f"/Mat{number}", diffuseColor=(usd.texture(f"/T{number}", file), "rgb"))
    assert len(usd.load().textures) == 1


@pytest.mark.parametrize("file", ["none.png", "tile.<UDIM>.png"])
def test_missing_files_are_said(usd: UsdFile, file: str) -> None:
    colored(usd, file)
    scene = usd.load()
    assert scene.materials[0].base_color_slot is None
    assert any("left out" in sentence and file in sentence for sentence in scene.report.ignored)


@pytest.mark.parametrize(
    "name", ["Maps/A.PNG", "maps\\\\a.png", "C:/job/maps/a.png", "/home/me/maps/a.png", "file:///C:/job/Maps/a.png"]
)
def test_files_are_found_as_those_of_other_formats_are(usd: UsdFile, name: str) -> None:
    (usd.folder / "maps").mkdir()
    usd.image("maps/a.png", [[(1, 2, 3)]])
    colored(usd, name)
    scene = usd.load()
    assert scene.materials[0].base_color_slot is not None


def test_files_outside_the_folder_are_refused(usd: UsdFile) -> None:
    usd.image("../a.png", [[(1, 2, 3)]])
    colored(usd, "../a.png")
    with pytest.raises(SceneError, match="is outside the scene's folder"):
        usd.load()


def test_broken_and_large_images(usd: UsdFile) -> None:
    (usd.folder / "a.png").write_bytes(b"no image")
    colored(usd, "a.png")
    scene = usd.load()
    assert scene.materials[0].base_color_slot is None
    assert scene.report.ignored[0].startswith("a.png: not an image that can be read")
    usd.image("a.png", [[(1, 2, 3)] * 8])
    with pytest.raises(SceneError, match="max_texture_size"):
        load_usd(usd.write(), SceneLimits(max_texture_size=4))


@pytest.mark.parametrize("name", ["a.png", "gr\N{LATIN SMALL LETTER U WITH DIAERESIS}n.png"])
def test_textures_of_a_package(usd: UsdFile, name: str) -> None:
    colored(usd, usd.image(name, [[(1, 2, 3)]]))
    path = usd.write()
    assert UsdUtils.CreateNewUsdzPackage(str(path), str(usd.folder / "scene.usdz"))
    (usd.folder / name).unlink()
    assert load_usd(usd.folder / "scene.usdz").textures[0].pixels[0, 0].tolist() == [1, 2, 3, 255]

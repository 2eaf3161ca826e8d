"""MTL libraries: what a line changes of a material, and what is said of what is missing, unknown or broken."""

from pathlib import Path

import pytest
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.mtl import DEFAULT_MATERIAL, MaterialLibrary
from gpu.scene.types import Material


def library(folder: Path, text: str) -> MaterialLibrary:
    """That of an OBJ file in the folder which names the library `scene.mtl`."""
    (folder / "scene.mtl").write_text(text)
    read = MaterialLibrary(folder / "scene.obj", DEFAULT_LIMITS)
    read.read("scene.mtl")
    return read


def material(folder: Path, lines: str) -> Material:
    return library(folder, f"newmtl one\n{lines}\n").materials["one"]


def test_a_material_is_grey_until_a_line_says_otherwise(tmp_path: Path) -> None:
    materials = library(tmp_path, "# a comment\nKd 1 0 0\nnewmtl wall one\nnewmtl two\nKd 0.5\n").materials
    assert list(materials) == ["wall one", "two"]
    assert materials["wall one"].base_color == DEFAULT_MATERIAL.base_color == (0.8, 0.8, 0.8, 1.0)
    assert materials["two"].base_color == (0.5, 0.5, 0.5, 1.0)


def test_colours_emission_and_shininess(tmp_path: Path) -> None:
    lamp = material(tmp_path, "Kd 0.1 0.2 0.3\nKe 7 8 9\nKs 0 0.1 0\nNs 6")
    assert (lamp.base_color, lamp.emission, lamp.specular) == ((0.1, 0.2, 0.3, 1.0), (7, 8, 9), 1.0)
    assert lamp.roughness**4 == pytest.approx(2.0 / (6.0 + 2.0))
    assert material(tmp_path, "Ks 0 0 0").specular == 0.0


def test_a_texture_takes_the_place_of_the_colour_and_of_no_emission(tmp_path: Path) -> None:
    Image.new("RGB", (1, 1), (255, 0, 0)).save(tmp_path / "red brick.png")
    read = library(tmp_path, "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd red brick.png\nmap_Ke red brick.png\n"
                             "newmtl b\nKe 2 2 2\nmap_Ke red brick.png\n")  # fmt: skip
    (texture,) = read.textures  # read once
    assert texture.srgb
    assert texture.pixels.tolist() == [[[255, 0, 0, 255]]]
    a, b = read.materials.values()
    assert (a.base_color, a.emission, b.emission) == ((1, 1, 1, 1), (1, 1, 1), (2, 2, 2))
    assert [slot.texture for slot in (a.base_color_slot, a.emission_slot, b.emission_slot) if slot] == [0, 0, 0]


def test_what_is_missing_or_not_supported_is_said_once(tmp_path: Path) -> None:
    read = library(tmp_path, "newmtl m\nmap_Kd -s 2 2 1 none.png\nd 0.5\nd 0.6\n")
    read.read("b.mtl")
    assert read.materials["m"].base_color_slot is None
    assert list(read.ignored) == [
        "options of MTL textures are not supported and were ignored",
        "texture none.png is missing",
        "d of MTL materials is not supported and was ignored",
        "material library b.mtl is missing: its surfaces are grey",
    ]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("Kd red", "must be numbers of at least 0"),
        ("Kd -1 0 0", "must be numbers of at least 0"),
        ("Kd nan 0 0", "must be numbers of at least 0"),
        ("Ke 1 2", "must be 1 or 3 numbers"),
        ("map_Kd /etc/hostname", "'/etc/hostname' is outside"),
        ("map_Kd scene.mtl", "scene.mtl: not an image"),
    ],
)
def test_what_is_broken_is_named_by_its_line(tmp_path: Path, line: str, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        material(tmp_path, line)
    assert f"scene.mtl: line 2: {says}" in str(caught.value)
    assert "scene.obj" in str(caught.value)


def test_a_library_outside_the_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"mtllib: '\.\./scene\.mtl' is outside"):
        MaterialLibrary(tmp_path / "scene.obj", DEFAULT_LIMITS).read("../scene.mtl")

"""MTL libraries: what a material is by its statements, and what is said of what is missing, unknown or broken."""

from pathlib import Path

import pytest
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.formats.mtl import DEFAULT_MATERIAL, MaterialLibrary
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.remarks import Remarks
from gpu.scene.types import AlphaMode, Material


def library(folder: Path, text: str, remarks: Remarks | None = None) -> MaterialLibrary:
    """That of an OBJ file in the folder which names the library `scene.mtl`."""
    (folder / "scene.mtl").write_text(text)
    read = MaterialLibrary(folder / "scene.obj", DEFAULT_LIMITS, remarks or Remarks())
    read.read("scene.mtl")
    return read


def material(folder: Path, lines: str, remarks: Remarks | None = None) -> Material:
    found = library(folder, f"newmtl one\n{lines}\n", remarks).find("one")
    assert found is not None
    return found


def test_a_material_is_grey_until_a_line_says_otherwise(tmp_path: Path) -> None:
    read = library(tmp_path, "# a comment\nnewmtl wall  one\nnewmtl two\nKd 0.5\n")
    wall, two = read.find("wall one"), read.find("two # the second")
    assert wall is not None
    assert two is not None
    assert wall.base_color == DEFAULT_MATERIAL.base_color == (0.8, 0.8, 0.8, 1.0)
    assert (two.base_color, read.find("three")) == ((0.5, 0.5, 0.5, 1.0), None)


def test_colours_emission_and_shininess(tmp_path: Path) -> None:
    lamp = material(tmp_path, "\tkd\t0.1 0.2 0.3 # paint\n KE 7 8 9\nKs 0 0.1 0\nNs 6\nNi 1.8")
    assert (lamp.base_color, lamp.emission, lamp.specular) == ((0.1, 0.2, 0.3, 1.0), (7, 8, 9), 1.0)
    assert lamp.roughness**4 == pytest.approx(2.0 / (6.0 + 2.0))
    assert lamp.ior == 1.8
    assert material(tmp_path, "Ks 0 0 0\nNi 1").specular == 0.0


@pytest.mark.parametrize(
    ("lines", "opacity"),
    [("d 0.25", 0.25), ("Tr 0.75", 0.25), ("Tr 1\nd 1", 1.0), ("d -halo 0.5", 0.5), ("Tr 1", 1.0), ("d 7", 1.0)],
)
def test_opacity(tmp_path: Path, lines: str, opacity: float) -> None:
    glass = material(tmp_path, lines)
    assert glass.base_color[3] == opacity
    assert glass.alpha_mode is (AlphaMode.BLEND if opacity < 1.0 else AlphaMode.OPAQUE)


def test_metals_of_the_physically_based_extension(tmp_path: Path) -> None:
    gold = material(tmp_path, "Pm 1\nPr 0.25\nNs 6")
    assert (gold.metallic, gold.roughness, gold.specular) == (1.0, 0.25, 1.0)


def test_the_order_of_statements_means_nothing(tmp_path: Path) -> None:
    Image.new("RGB", (1, 1), (255, 0, 0)).save(tmp_path / "red brick.png")
    first = "Kd 0 0 0\nKe 0 0 0\nmap_Kd red brick.png\nmap_Ke red brick.png\n"
    last = "map_Ke red brick.png\nmap_Kd red brick.png\nKe 0 0 0\nKd 0 0 0\n"
    read = library(tmp_path, f"newmtl a\n{first}newmtl b\n{last}newmtl c\nKe 2 2 2\nmap_Ke red brick.png\n")
    a, b, c = (read.find(name) for name in "abc")
    assert a is not None
    assert b is not None
    assert c is not None
    assert (a.base_color, a.emission) == (b.base_color, b.emission) == ((1, 1, 1, 1), (1, 1, 1))
    assert a.base_color_slot == b.base_color_slot
    assert c.emission == (2, 2, 2)
    assert len(read.textures) == 1  # read once


def test_maps_of_roughness_normals_and_opacity(tmp_path: Path) -> None:
    for name, level in (("r", 51), ("m", 255), ("n", 128), ("d", 0)):
        Image.new("L", (2, 2), level).save(tmp_path / f"{name}.png")
    remarks = Remarks()
    read = library(
        tmp_path, "newmtl one\nmap_Pr r.png\nmap_Pm m.png\nnorm -bm 0.5 n.png\nmap_d d.png\nmap_Bump n.png\n", remarks
    )
    one = read.find("one")
    assert one is not None
    assert (one.roughness, one.metallic, one.normal_scale, one.alpha_mode) == (1.0, 1.0, 0.5, AlphaMode.BLEND)
    assert one.base_color == (0.8, 0.8, 0.8, 1.0)
    slots = (one.base_color_slot, one.metallic_roughness_slot, one.normal_slot)
    pixels = [read.textures[slot.texture].pixels[0, 0].tolist() for slot in slots if slot]
    assert pixels == [[255, 255, 255, 0], [255, 51, 255, 255], [128, 128, 128, 255]]
    assert [read.textures[slot.texture].srgb for slot in slots if slot] == [True, False, False]
    assert remarks.sentences() == ("map_bump of MTL materials is not supported and was ignored",)


@pytest.mark.parametrize(
    "names", ["a.mtl b.mtl", "a.mtl\tb.mtl", "my walls.mtl a.mtl b.mtl", '"my walls.mtl"', "B.MTL a.mtl"]
)
def test_several_libraries_and_names_with_spaces(tmp_path: Path, names: str) -> None:
    for name in ("a", "b", "my walls"):
        (tmp_path / f"{name}.mtl").write_text(f"newmtl {name}\nKd 1 0 0\n")
    remarks = Remarks()
    read = MaterialLibrary(tmp_path / "scene.obj", DEFAULT_LIMITS, remarks)
    read.read(names)
    wanted = [name for name in ("a", "b", "my walls") if f"{name}.mtl" in names]
    assert all(read.find(name) is not None for name in wanted)


@pytest.mark.parametrize(
    ("lines", "says", "base_color"),
    [
        ("Kd red", "kd 'red' is not 1 or 3 numbers of at least 0: 0.8 0.8 0.8 was taken", (0.8, 0.8, 0.8, 1)),
        ("Kd -1 0 0", "is not 1 or 3 numbers", (0.8, 0.8, 0.8, 1)),
        ("Kd nan 0 0", "is not 1 or 3 numbers", (0.8, 0.8, 0.8, 1)),
        ("Kd 1 2", "is not 1 or 3 numbers", (0.8, 0.8, 0.8, 1)),
        ("Kd 0.1 0.2 0.3 1", "more than 3 numbers", (0.1, 0.2, 0.3, 1)),
        ("Kd 2 0 0", "is above 1, which was taken", (1, 0, 0, 1)),
        ("Kd xyz 0.9505 1 1.089", "was converted to Rec. 709", (1, 1, 1, 1)),
        ("Ks nan nan nan", "ks 'nan nan nan' is not", (0.8, 0.8, 0.8, 1)),
        ("Ns -1.#IND", "ns '-1.#IND' is not a number of at least 0: 0 was taken", (0.8, 0.8, 0.8, 1)),
        ("Ns -2", "is not a number of at least 0", (0.8, 0.8, 0.8, 1)),
        ("d 0", "material one: is not seen at all", (0.8, 0.8, 0.8, 0)),
        ("Ka 1 1 1\nKa 0.5 0 0\nillum 4", "ka of MTL materials is not supported and was ignored", (0.8, 0.8, 0.8, 1)),
        ("map_Kd none.png", "texture none.png is missing", (0.8, 0.8, 0.8, 1)),
        ("map_Kd scene.mtl", "scene.mtl: line 2: texture scene.mtl was ignored: not an image", (0.8, 0.8, 0.8, 1)),
        ("map_Kd -s 2 2", "names no file", (0.8, 0.8, 0.8, 1)),
    ],
)
def test_what_is_odd_costs_its_value_and_a_sentence(
    tmp_path: Path, lines: str, says: str, base_color: tuple[float, ...]
) -> None:
    remarks = Remarks()
    found = material(tmp_path, lines, remarks)
    assert found.base_color == pytest.approx(base_color, abs=1e-3)
    assert says in " ".join(remarks.sentences())


def test_ten_thousand_odd_values_are_one_sentence(tmp_path: Path) -> None:
    remarks = Remarks()
    read = library(tmp_path, "".join(f"newmtl m{n}\nNs -{n + 1}\n" for n in range(1000)), remarks)
    assert all(read.find(f"m{n}") for n in range(1000))
    assert len(remarks.sentences()) == 1


def test_a_name_that_is_defined_twice_is_said(tmp_path: Path) -> None:
    remarks = Remarks()
    read = library(tmp_path, "Kd 1 0 0\nnewmtl a\nKd 0 0 1\nnewmtl a\nKd 0 1 0\n", remarks)
    read.read("b.mtl")
    found = read.find("a")
    assert found is not None
    assert found.base_color == (0, 0, 1, 1)
    assert remarks.sentences() == (
        "scene.mtl: line 1: a statement before the first newmtl was ignored",
        "material a is defined twice: the first counts",
        "material library b.mtl is missing: scene.mtl was read",
    )


def test_what_leaves_the_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"mtllib: '\.\./scene\.mtl' is outside"):
        MaterialLibrary(tmp_path / "scene.obj", DEFAULT_LIMITS, Remarks()).read("../scene.mtl")
    with pytest.raises(SceneError, match=r"scene.mtl: line 2: '\.\./\.\./x\.png' is outside"):
        material(tmp_path, "map_Kd ../../x.png")


@pytest.mark.parametrize(
    ("color", "says"),
    [
        ((128, 128, 255), "a map_bump of MTL materials that has the colours of a normal map was taken as one"),
        ((128, 128, 128), "map_bump of MTL materials is not supported and was ignored"),
        ((255, 255, 255), "map_bump of MTL materials is not supported and was ignored"),
    ],
)
def test_a_bump_map_counts_where_it_is_a_normal_map(tmp_path: Path, color: tuple[int, int, int], says: str) -> None:
    Image.new("RGB", (4, 4), color).save(tmp_path / "n.png")
    remarks = Remarks()
    bumpy = material(tmp_path, "map_Bump -bm 0.5 n.png", remarks)
    assert (bumpy.normal_slot is not None, bumpy.normal_scale) == ((True, 0.5) if "taken" in says else (False, 1.0))
    assert remarks.sentences() == (says,)


def test_instead_of_a_missing_library_that_of_the_scenes_name_is_read_once(tmp_path: Path) -> None:
    remarks = Remarks()
    read = library(tmp_path, "newmtl one\nKd 1 0 0\n", remarks)
    read.read("untitled.mtl")
    read.read("scene.mtl")
    assert remarks.sentences() == ("material library untitled.mtl is missing: scene.mtl was read",)
    lost = MaterialLibrary(tmp_path / "other.obj", DEFAULT_LIMITS, remarks)
    lost.read("gone.mtl")
    assert "material library gone.mtl is missing: its surfaces are grey" in remarks.sentences()

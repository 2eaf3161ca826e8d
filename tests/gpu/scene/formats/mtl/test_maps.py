"""Files of MTL maps: where they are sought, and the textures made of them."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gpu.scene.formats.mtl.maps import MapFiles, MapImage
from gpu.scene.formats.mtl.statements import MtlMaterial
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.remarks import Remarks
from gpu.scene.types import Wrap


def image(files: MapFiles, library: Path, value: str) -> MapImage | None:
    return files.image(MtlMaterial("m", Remarks(), {"map_kd": (value, "scene.mtl: line 2")}), "map_kd", library)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene's folder with a library in a folder of its own, and images of red levels 10, 20 and 30."""
    (tmp_path / "materials").mkdir()
    (tmp_path / "textures").mkdir()
    for place, level in (("materials/both.png", 10), ("both.png", 20), ("textures/a #2 b.png", 30)):
        Image.new("RGB", (2, 3), (level, 0, 0)).save(tmp_path / place)
    return tmp_path


@pytest.mark.parametrize(
    ("value", "level"),
    [
        ("both.png", 10),
        (".\\both.png", 10),
        ("both.png # of the wall", 10),
        ("-s 2 2 2 -o 0.5 both.png", 10),
        ("..\\both.png", 20),
        ("textures/a #2 b.png", 30),
        ("../textures/a #2 b.png", 30),
        ('"textures/a #2 b.png"', 30),
        ("C:\\Users\\me\\both.png", 10),
        ("/home/me/both.png", 10),
        ("C:\\job\\Textures\\a #2 b.png", 30),
        ("none.png", None),
        ("../none.png", None),
        ("/etc/hostname", None),
    ],
)
def test_maps_are_sought_beside_the_library_then_beside_the_scene(folder: Path, value: str, level: int | None) -> None:
    remarks = Remarks()
    files = MapFiles(folder / "scene.obj", DEFAULT_LIMITS, remarks)
    found = image(files, (folder / "materials/house.mtl").resolve(), value)
    assert (found is None) == (level is None)
    if found is None:
        assert "is missing" in remarks.sentences()[0]
    else:
        assert found.pixels[0, 0, 0] == level


def test_options_lay_the_texture(folder: Path) -> None:
    files = MapFiles(folder / "scene.obj", DEFAULT_LIMITS, Remarks())
    found = image(files, folder / "scene.mtl", "-clamp on -s 2 4 1 -o 0.25 0.5 0 both.png")
    assert found is not None
    slot = files.color_slot(found, None)
    matrix = np.array(slot.transform).reshape(2, 3)
    for u, v in ((0.0, 0.0), (0.3, 0.8)):  # v from the bottom, as in the file
        assert matrix @ (u, 1.0 - v, 1.0) == pytest.approx((2.0 * u + 0.25, 1.0 - (4.0 * v + 0.5)))
    assert files.textures[slot.texture].wrap_s is Wrap.CLAMP


def test_a_mask_of_another_size_becomes_the_alpha(folder: Path) -> None:
    Image.new("L", (4, 6), 77).save(folder / "mask.png")
    files = MapFiles(folder / "scene.obj", DEFAULT_LIMITS, Remarks())
    base, mask = (image(files, folder / "scene.mtl", name) for name in ("both.png", "mask.png"))
    slots = [files.color_slot(base, mask), files.color_slot(base, mask), files.color_slot(base, None)]
    assert [slot.texture for slot in slots] == [0, 0, 1]
    assert files.textures[0].pixels.shape == (3, 2, 4)
    assert (files.textures[0].pixels == (20, 0, 0, 77)).all()

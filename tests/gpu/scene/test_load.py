import sys
from pathlib import Path

import pytest

from gpu.errors import SceneError
from gpu.scene.builtin import BUILTIN
from gpu.scene.load import load_scene


def test_a_built_in_scene_by_its_name() -> None:
    assert load_scene("cornell-box").name == "cornell-box"


@pytest.mark.parametrize("name", ["A.OFF", "a.off"])
def test_a_file_by_its_suffix(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert len(load_scene(str(path)).triangles) == 1


def test_a_scene_knows_the_files_that_it_was_read_with(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("mtllib sub/a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.mtl").write_text("newmtl red\nmap_Kd wood.png\n")
    beside = load_scene(str(tmp_path / "a.obj")).report.beside
    assert beside["sub/a.mtl"] == (tmp_path / "sub" / "a.mtl").stat().st_mtime_ns
    assert beside["sub/wood.png"] == 0  # which may come
    assert load_scene("cornell-box").report.beside == {}


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [
        ("a.ifc", "ifcopenshell.geom", "ifc"),
        ("a.ifczip", "ifcopenshell.geom", "ifc"),
        ("a.stp", "cascadio", "step"),
        ("a.usdz", "pxr", "usd"),
        ("a.fbx", "ufbx", "fbx"),
    ],
)
def test_a_format_whose_library_is_missing_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, module: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(SceneError, match=rf"needs the extra {extra}: pip install lumenwalk\[{extra}\]"):
        load_scene(str(tmp_path / name))


@pytest.mark.parametrize("source", ["kitchen", "kitchen.blend", ""])
def test_what_is_no_scene_is_told_what_there_is(source: str) -> None:
    with pytest.raises(SceneError, match=r"\.gltf") as caught:
        load_scene(source)
    assert all(name in str(caught.value) for name in BUILTIN)


@pytest.mark.parametrize("name", ["house.zip", "HOUSE.OBJ.GZ", "a.7z"])
def test_an_archive_is_to_be_unpacked(name: str) -> None:
    with pytest.raises(SceneError, match="is an archive; unpack it"):
        load_scene(name)

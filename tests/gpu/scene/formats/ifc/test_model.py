import io
import zipfile
from pathlib import Path

import pytest
from ifc_file import House

from gpu.errors import SceneError
from gpu.scene.formats.ifc.model import open_model
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits

pytest.importorskip("ifcopenshell", reason="the extra ifc is not installed")


@pytest.fixture(scope="module")
def house() -> bytes:
    return House().bytes()


def zipped(*files: tuple[str, bytes]) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files:
            archive.writestr(name, data)
    return content.getvalue()


def test_an_ifczip_holds_one_model(tmp_path: Path, house: bytes) -> None:
    path = tmp_path / "house.ifczip"
    path.write_bytes(zipped(("deep/House.IFC", house), ("notes.txt", b"")))
    assert len(open_model(path, DEFAULT_LIMITS)[0].by_type("IfcWall")) == 2
    for content, says in (
        (zipped(("a.txt", b"")), "0 .ifc files in the .ifczip; there must be one"),
        (zipped(("a.ifc", house), ("b.ifc", house)), "2 .ifc files"),
        (house, "not a .ifczip file"),
        (zipped(("a.ifc", house))[:-30], "not a .ifczip file"),
    ):
        path.write_bytes(content)
        with pytest.raises(SceneError, match=says):
            open_model(path, DEFAULT_LIMITS)


def test_an_ifczip_unpacks_to_no_more_than_a_file_may_have(tmp_path: Path, house: bytes) -> None:
    path = tmp_path / "house.ifczip"
    path.write_bytes(zipped(("a.ifc", house + b" " * 100_000)))
    with pytest.raises(SceneError, match="max_file_bytes"):
        open_model(path, SceneLimits(max_file_bytes=100_000))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (b"ISO-10303-21;", b"<ifcXML>", "does not begin with ISO-10303-21"),
        (b"END-ISO-10303-21;", b"", "cut off"),
        (b"'IFC4'", b"'IFC9'", "FILE_SCHEMA: .*export it as IFC2X3, IFC4 or IFC4X3"),
        (b"FILE_SCHEMA", b"FILE_SHEMA", "FILE_SCHEMA"),
    ],
)
def test_what_is_no_ifc_file_is_refused(tmp_path: Path, house: bytes, old: bytes, new: bytes, says: str) -> None:
    path = tmp_path / "house.ifc"
    path.write_bytes(house.replace(old, new))
    with pytest.raises(SceneError, match=says):
        open_model(path, DEFAULT_LIMITS)


def test_broken_statements_are_counted(tmp_path: Path, house: bytes) -> None:
    path = tmp_path / "house.ifc"
    path.write_bytes(house.replace(b"IFCWINDOW(", b"IFCWINDOWS("))
    model, sentences = open_model(path, DEFAULT_LIMITS)
    assert len(model.by_type("IfcWall")) == 2
    assert len(sentences) == 1
    assert "Entity with name 'IFCWINDOWS' not found" in sentences[0]
    path.write_bytes(house)
    assert open_model(path, DEFAULT_LIMITS)[1] == []

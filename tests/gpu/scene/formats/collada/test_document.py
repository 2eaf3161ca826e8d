import io
import zipfile
from pathlib import Path

import pytest
from dae_file import dae

from gpu.errors import SceneError
from gpu.scene.formats.collada import load_collada
from gpu.scene.formats.collada.document import open_document
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits


def zae(files: dict[str, bytes]) -> bytes:
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return written.getvalue()


@pytest.mark.parametrize(
    ("asset", "up", "metres"),
    [
        ('<unit meter="0.01"/><up_axis>Z_UP</up_axis>', "z", 0.01),
        ('<unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis>', "y", 0.0254),
        ("<up_axis>X_UP</up_axis>", "y", None),
        ('<unit meter="0"/>', None, None),
        ('<unit meter="a"/>', None, None),
        ("<up_axis>Z-UP</up_axis>", None, None),
    ],
)
def test_unit_and_up_axis(tmp_path: Path, asset: str, up: str | None, metres: float | None) -> None:
    (tmp_path / "a.dae").write_bytes(dae(asset=asset))
    document = open_document(tmp_path / "a.dae", DEFAULT_LIMITS)
    assert (document.up, document.metres_per_unit) == (up, metres)
    assert any("no number of metres" in said for said in document.remarks.sentences()) == (
        "unit" in asset and not metres
    )
    assert any("the axis that is up is not known" in said for said in document.remarks.sentences()) == ("Z-" in asset)


@pytest.mark.parametrize(
    "content",
    [
        zae({"scene.dae": dae()}),
        zae({"__MACOSX/a.dae": b"", "b/scene.DAE": dae()}),
        zae({"o.dae": b"", "manifest.xml": b"<dae_root>./in%20it/a.dae#scene</dae_root>", "in it/a.dae": dae()}),
    ],
)
def test_a_zae_holds_a_scene(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.zae").write_bytes(content)
    assert len(load_collada(tmp_path / "a.zae").triangles) == 2


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.dae", b"", "not XML that can be read"),
        ("a.dae", dae()[:900], "not XML that can be read: .*line 1"),
        ("a.dae", b"<html/>", "not a COLLADA file: its root is 'html'"),
        ("a.dae", zae({"a.dae": dae()}), "not XML"),
        ("a.dae", b"<COLLADA/>", "no visual scene"),
        ("a.dae", b'<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;</COLLADA>', "declares a document type"),
        ("a.zae", dae(), r"not a \.zae file"),
        ("a.zae", zae({"a.txt": b""}), r"there is no \.dae file"),
    ],
)
def test_what_is_none_is_refused(tmp_path: Path, name: str, content: bytes, says: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=says):
        load_collada(tmp_path / name)


def test_a_zae_unpacks_to_no_more_than_a_file_may_have(tmp_path: Path) -> None:
    (tmp_path / "a.zae").write_bytes(zae({"a.dae": dae() + b" " * 100_000}))
    with pytest.raises(SceneError, match="bytes unpacked"):
        load_collada(tmp_path / "a.zae", SceneLimits(max_file_bytes=50_000))

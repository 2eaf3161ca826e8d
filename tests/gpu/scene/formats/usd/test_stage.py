import zipfile
from pathlib import Path

import pytest
from usd_file import UsdFile

from gpu.errors import SceneError
from gpu.scene.formats.usd import load_usd
from gpu.scene.limits import SceneLimits

pytest.importorskip("pxr")
from pxr import Sdf, UsdUtils

HEAD = "#usda 1.0\n"
SQUARE = """
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
"""


def layer(folder: Path, name: str, prim: str = "Mesh") -> None:
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text(f'{HEAD}( defaultPrim = "{prim}" )\ndef Mesh "{prim}" {{{SQUARE}}}\n')


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.usda", b"garbage"),
        ("a.usda", b'#usda 1.0\ndef Xform "A" {'),
        ("a.usdc", b"PXR-USDC" + bytes(100)),
        ("a.usdz", b"PK\x03\x04cut off"),
        ("a.usd", b""),
        ("a.usda", b'#usda 1.0\ndef \xa0 "A" {}'),  # which USD repeats
    ],
)
def test_broken_files(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=r"not a USD file that can be read") as caught:
        load_usd(tmp_path / name)
    assert str(tmp_path) not in caught.value.problem


def test_a_value_of_another_type(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text('#usda 1.0\ndef Mesh "A" {\npnt3f[] points = [(1, 0, 0)]\n}\n')
    with pytest.raises(SceneError, match="a value of another type than it should"):
        load_usd(tmp_path / "a.usda")


def test_a_missing_and_a_large_file(usd: UsdFile) -> None:
    with pytest.raises(SceneError, match="cannot be read"):
        load_usd(usd.folder / "none.usda")
    usd.mesh()
    with pytest.raises(SceneError, match="max_file_bytes"):
        load_usd(usd.write(), SceneLimits(max_file_bytes=20))


@pytest.mark.parametrize("name", ["scene.usd", "scene.usda", "scene.usdc"])
def test_text_and_binary(usd: UsdFile, name: str) -> None:
    usd.mesh()
    assert len(load_usd(usd.write(name)).triangles) == 2


def test_layers_of_the_folder_are_joined(usd: UsdFile) -> None:
    layer(usd.folder, "parts/chair.usda")
    layer(usd.folder, "below.usda", "Below")
    usd.stage.OverridePrim("/Chair").GetReferences().AddReference("parts/chair.usda")
    usd.stage.OverridePrim("/Payload").GetPayloads().AddPayload("./parts/../parts/chair.usda")
    for path in ("/Chair", "/Payload"):
        usd.stage.GetPrimAtPath(path).SetSpecifier(Sdf.SpecifierDef)
    usd.stage.GetRootLayer().subLayerPaths.append("below.usda")
    scene = usd.load()
    assert len(scene.triangles) == 6


@pytest.mark.parametrize("kind", ["sublayer", "reference", "payload", "variant"])
@pytest.mark.parametrize("asset", ["../outside.usda", "/outside.usda", "link.usda"])
def test_layers_outside_the_folder_are_refused(usd: UsdFile, kind: str, asset: str) -> None:
    layer(usd.folder.parent, "outside.usda")
    (usd.folder / "link.usda").symlink_to(usd.folder.parent / "outside.usda")
    asset = asset.replace("/outside", f"{usd.folder.parent}/outside") if asset[0] == "/" else asset
    head = f"( subLayers = [@{asset}@] )" if kind == "sublayer" else ""
    arc = f"( {kind}s = @{asset}@ )".replace("payloads", "payload")
    body = {
        "sublayer": "",
        "variant": f'( variantSets = "v" ) {{ variantSet "v" = {{ "a" ( references = @{asset}@ ) {{\n}}\n}}\n}}',
    }.get(kind, f"{arc} {{\n}}")
    (usd.folder / "scene.usda").write_text(f'{HEAD}{head}\ndef Mesh "M" {{{SQUARE}}}\ndef "X" {body or "{ }"}\n')
    with pytest.raises(SceneError, match="is outside the scene's folder"):
        load_usd(usd.folder / "scene.usda")


@pytest.mark.parametrize("asset", ["none.usda", "http://example.org/a.usda", '`"${X}"`', "notes.txt"])
def test_layers_that_are_not_there_are_left_out(usd: UsdFile, asset: str, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere = usd.folder.parent / "elsewhere"
    layer(elsewhere, "none.usda")
    monkeypatch.chdir(elsewhere)  # where USD looks for files by itself
    (usd.folder / "notes.txt").write_text("no scene")
    usd.mesh()
    usd.stage.DefinePrim("/Other").GetReferences().AddReference(asset)
    scene = usd.load()
    assert len(scene.triangles) == 2
    assert "left out" in scene.report.ignored[0]


def test_what_cannot_be_composed_is_said(usd: UsdFile, capfd: pytest.CaptureFixture) -> None:
    usd.mesh()
    usd.stage.DefinePrim("/Other").GetReferences().AddInternalReference("/Nowhere")
    scene = load_usd(usd.write())
    assert "USD cannot compose a part of the scene" in scene.report.ignored[0]
    assert str(usd.folder) not in scene.report.ignored[0]


def test_a_package(usd: UsdFile) -> None:
    layer(usd.folder, "parts/chair.usda")
    usd.stage.DefinePrim("/Chair").GetReferences().AddReference("./parts/chair.usda")
    path = usd.write()
    assert UsdUtils.CreateNewUsdzPackage(str(path), str(usd.folder / "scene.usdz"))
    (usd.folder / "parts/chair.usda").unlink()
    assert len(load_usd(usd.folder / "scene.usdz").triangles) == 2


def test_a_package_that_refers_outside(usd: UsdFile) -> None:
    layer(usd.folder.parent, "outside.usda")
    usd.mesh()
    usd.stage.DefinePrim("/Other").GetReferences().AddReference(str(usd.folder.parent / "outside.usda"))
    with zipfile.ZipFile(usd.folder / "scene.usdz", "w") as package:
        package.write(usd.write(), "scene.usda")
    with pytest.raises(SceneError, match="is outside the scene's folder"):
        load_usd(usd.folder / "scene.usdz")


def test_clips_bring_in_no_layers(usd: UsdFile) -> None:
    layer(usd.folder.parent, "outside.usda")
    mesh = usd.mesh()
    clips = {"default": {"assetPaths": Sdf.AssetPathArray([Sdf.AssetPath("../outside.usda")]), "primPath": "/Mesh"}}
    mesh.GetPrim().SetMetadata("clips", clips)
    assert len(usd.load().triangles) == 2


def test_the_first_time_of_an_animation_is_shown(usd: UsdFile) -> None:
    mesh = usd.mesh()
    points = mesh.GetPointsAttr()
    first = points.Get()
    points.Clear()
    points.Set(first, 10.0)
    points.Set([(9, 9, 9)] * 4, 20.0)
    usd.stage.SetStartTimeCode(10.0)
    usd.stage.SetEndTimeCode(20.0)
    scene = usd.load()
    assert len(scene.triangles) == 2
    assert "animations are not played; the scene is shown at its first time" in scene.report.ignored

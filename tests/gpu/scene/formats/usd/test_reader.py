import numpy as np
import pytest
from usd_file import UsdFile, facing, world

from gpu.errors import SceneError
from gpu.scene.formats.usd import load_usd
from gpu.scene.import_options import ImportOptions
from gpu.scene.load import load_scene

pytest.importorskip("pxr")
from pxr import UsdGeom


@pytest.mark.parametrize(("up", "normal"), [("Y", (0, 0, 1)), ("Z", (0, 1, 0))])
def test_units_and_axes(usd: UsdFile, up: str, normal: tuple) -> None:
    UsdGeom.SetStageUpAxis(usd.stage, up)
    UsdGeom.SetStageMetersPerUnit(usd.stage, 0.01)
    usd.mesh()
    scene = load_scene(str(usd.write()))
    assert np.allclose(facing(scene) * 1e4, normal, atol=1e-6)
    assert scene.frame.metres_per_unit == pytest.approx(0.01)


def test_options_overrule_the_file(usd: UsdFile) -> None:
    usd.mesh()
    assert world(load_usd(usd.write(), options=ImportOptions(unit="mm"))).max() == pytest.approx(0.001)


def test_what_is_not_shown_is_said(usd: UsdFile) -> None:
    usd.mesh()
    UsdGeom.Points.Define(usd.stage, "/Points")
    for number in range(3):
        UsdGeom.BasisCurves.Define(usd.stage, f"/Hair{number}")
    usd.stage.DefinePrim("/Skinned", "SkelRoot")
    assert set(usd.load().report.ignored) == {
        "/Points: prims of kind Points are not shown",
        "/Hair0: prims of kind BasisCurves are not shown (likewise /Hair1, /Hair2)",
        "/Skinned: skinned meshes are shown in their bind pose",
    }


def test_an_empty_stage(usd: UsdFile) -> None:
    with pytest.raises(SceneError, match="no triangles"):
        usd.load()

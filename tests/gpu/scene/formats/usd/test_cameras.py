import numpy as np
import pytest
from usd_file import UsdFile

pytest.importorskip("pxr")
from pxr import UsdGeom


def camera(usd: UsdFile, width: float = 24.0, height: float = 18.0, length: float = 24.0) -> UsdGeom.Camera:
    made = UsdGeom.Camera.Define(usd.stage, "/View")
    made.CreateHorizontalApertureAttr(width)
    made.CreateVerticalApertureAttr(height)
    made.CreateFocalLengthAttr(length)
    usd.mesh()
    return made


def test_a_perspective_camera(usd: UsdFile) -> None:
    UsdGeom.SetStageUpAxis(usd.stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(usd.stage, 0.01)
    xform = UsdGeom.Xformable(camera(usd))
    xform.AddTranslateOp().Set((100, 200, 300))
    xform.AddRotateXOp().Set(90.0)  # looks along +Y, which becomes −Z
    (view,) = usd.load().cameras
    assert view.name == "View"
    assert view.half_height == pytest.approx(0.375)
    assert view.aspect == pytest.approx(4.0 / 3.0)
    assert np.allclose(view.to_world[:3, 3], (1, 3, -2))
    assert np.allclose(view.to_world[:3, :3], np.eye(3), atol=1e-9)


def test_an_orthographic_camera(usd: UsdFile) -> None:
    camera(usd, 60.0, 40.0).CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    (view,) = usd.load().cameras
    assert view.orthographic
    assert view.half_height == pytest.approx(2.0)


def test_cameras_that_show_nothing_are_said(usd: UsdFile) -> None:
    camera(usd, length=0.0)
    scene = usd.load()
    assert "/View: a camera without aperture or focal length was left out" in scene.report.ignored
    assert len(scene.cameras) == 1  # the one that every scene gets


def test_shifted_apertures_are_said(usd: UsdFile) -> None:
    camera(usd).CreateHorizontalApertureOffsetAttr(2.0)
    assert "/View: shifted apertures of cameras are not shown" in usd.load().report.ignored

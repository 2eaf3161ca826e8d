from math import pi

import numpy as np
import pytest
from usd_file import UsdFile, facing, world

from gpu.scene.types import LightKind, Scene

pytest.importorskip("pxr")
from pxr import UsdGeom, UsdLux


def lit_area(scene: Scene) -> float:
    lit = np.array([any(material.emission) for material in scene.materials])[scene.triangle_material]
    return float(np.linalg.norm(facing(scene)[lit], axis=1).sum() / 2.0)


def emission(scene: Scene) -> tuple:
    return next(material.emission for material in scene.materials if any(material.emission))


def test_a_rectangle_shines_along_minus_z(usd: UsdFile) -> None:
    light = UsdLux.RectLight.Define(usd.stage, "/Lamp")
    light.CreateWidthAttr(2.0)
    light.CreateHeightAttr(3.0)
    light.CreateIntensityAttr(5.0)
    light.CreateExposureAttr(1.0)
    light.CreateColorAttr((1.0, 0.5, 0.25))
    UsdGeom.Xformable(light).AddTranslateOp().Set((0, 0, 7))
    scene = usd.load()
    assert emission(scene) == pytest.approx((10.0, 5.0, 2.5))
    assert lit_area(scene) == pytest.approx(6.0)
    assert (facing(scene)[:, 2] < 0.0).all()
    assert np.allclose(world(scene)[..., 2], 7.0)
    assert scene.materials[0].base_color[:3] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("kind", "attributes", "area"),
    [
        ("RectLight", {"width": 2.0, "height": 2.0}, 4.0),
        ("DiskLight", {"radius": 2.0}, 4.0 * pi),
        ("SphereLight", {"radius": 2.0}, 16.0 * pi),
        ("CylinderLight", {"radius": 1.0, "length": 3.0}, 6.0 * pi),
    ],
)
def test_normalised_lights_share_their_power_out(usd: UsdFile, kind: str, attributes: dict, area: float) -> None:
    usd.mesh()
    light = getattr(UsdLux, kind).Define(usd.stage, "/Lamp")
    for name, value in attributes.items():
        light.GetPrim().GetAttribute(f"inputs:{name}").Set(value)
    light.CreateIntensityAttr(12.0)
    light.CreateNormalizeAttr(True)
    UsdGeom.Xformable(light).AddScaleOp().Set((2, 2, 2))
    scene = usd.load()
    assert lit_area(scene) == pytest.approx(4.0 * area, rel=5e-3)
    assert emission(scene)[0] * lit_area(scene) == pytest.approx(12.0, rel=1e-3)


def test_colour_temperature(usd: UsdFile) -> None:
    light = UsdLux.DiskLight.Define(usd.stage, "/Lamp")
    light.CreateEnableColorTemperatureAttr(True)
    light.CreateColorTemperatureAttr(3000.0)
    red, green, blue = emission(usd.load())
    assert red > green > blue > 0.0


def test_a_sphere_as_a_point(usd: UsdFile) -> None:
    UsdGeom.SetStageMetersPerUnit(usd.stage, 0.01)
    usd.mesh()
    light = UsdLux.SphereLight.Define(usd.stage, "/Lamp")
    light.CreateTreatAsPointAttr(True)
    light.CreateRadiusAttr(10.0)
    light.CreateIntensityAttr(100.0)
    UsdGeom.Xformable(light).AddTranslateOp().Set((100, 0, 0))
    scene = usd.load()
    (point,) = scene.lights
    assert point.kind is LightKind.POINT
    in_watts = np.array(point.intensity) / scene.placement.scale**2
    assert in_watts == pytest.approx([100.0 * pi * 0.1**2] * 3, rel=1e-5)


@pytest.mark.parametrize(
    ("angle", "normalised", "irradiance"), [(0.0, False, 4.0), (0.53, True, 4.0), (90.0, False, 2.0 * pi)]
)
def test_distant_lights(usd: UsdFile, angle: float, normalised: bool, irradiance: float) -> None:
    usd.mesh()
    light = UsdLux.DistantLight.Define(usd.stage, "/Sun")
    light.CreateIntensityAttr(4.0)
    light.CreateAngleAttr(angle)
    light.CreateNormalizeAttr(normalised)
    UsdGeom.Xformable(light).AddRotateXOp().Set(-90.0)
    (sun,) = usd.load().lights
    assert sun.kind is LightKind.DIRECTIONAL
    assert sun.intensity == pytest.approx((irradiance,) * 3, rel=1e-5)
    assert sun.direction == pytest.approx((0.0, -1.0, 0.0), abs=1e-6)


def test_a_dome_is_a_sky(usd: UsdFile) -> None:
    usd.mesh()
    light = UsdLux.DomeLight.Define(usd.stage, "/Dome")
    light.CreateIntensityAttr(5.0)
    light.CreateTextureFileAttr(usd.image("sky.png", [[(255, 0, 0)], [(255, 0, 255)]]))
    scene = usd.load()
    assert scene.sky.radiance == pytest.approx((6.0, 0.0, 3.0))
    assert "/Dome: the mean of a light's texture counts, not its picture" in scene.report.ignored
    assert any("a dome light is shown as a sky" in sentence for sentence in scene.report.ignored)


def test_what_is_not_shown_is_said(usd: UsdFile) -> None:
    mesh = usd.mesh()
    UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    UsdLux.GeometryLight.Define(usd.stage, "/Geometry")
    light = UsdLux.DiskLight.Define(usd.stage, "/Lamp")
    light.CreateDiffuseAttr(0.5)
    UsdLux.ShapingAPI.Apply(light.GetPrim()).CreateShapingConeAngleAttr(30.0)
    light.CreateIntensityAttr(-5.0)
    sentences = usd.load().report.ignored
    assert "/Mesh: lights of kind MeshLightAPI are not shown" in sentences
    assert "/Geometry: lights of kind GeometryLight are not shown" in sentences
    assert "/Lamp: the diffuse multiplier of lights is not shown" in sentences
    assert "/Lamp: cones, focus and IES profiles of lights are not shown" in sentences

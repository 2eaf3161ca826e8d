import numpy as np
import pytest
from usd_file import UsdFile, facing, world

from gpu.errors import SceneError

pytest.importorskip("pxr")
from pxr import Gf, Sdf, UsdGeom


def test_transforms_are_joined(usd: UsdFile) -> None:
    for path, move in (("/A", (10, 0, 0)), ("/A/B", (0, 5, 0))):
        UsdGeom.Xform.Define(usd.stage, path).AddTranslateOp().Set(move)
    usd.mesh("/A/B/Mesh").AddScaleOp().Set((-2, 1, 1))
    usd.mesh("/A/B/Reset").SetResetXformStack(True)
    scene = usd.load()
    assert np.allclose(world(scene)[:2].reshape(-1, 3).min(axis=0), (8, 5, 0), atol=1e-5)
    assert np.allclose(world(scene)[2:].reshape(-1, 3).min(axis=0), (0, 0, 0), atol=1e-5)
    assert (facing(scene)[:, 2] > 0.0).all()  # the mirrored one is wound the other way


def test_native_instances(usd: UsdFile) -> None:
    usd.mesh("/Class/Mesh")
    usd.stage.GetPrimAtPath("/Class").SetSpecifier(Sdf.SpecifierClass)
    for number in range(3):
        prim = UsdGeom.Xform.Define(usd.stage, f"/I{number}")
        prim.AddTranslateOp().Set((number * 10.0, 0, 5))
        prim.GetPrim().GetReferences().AddInternalReference("/Class")
        prim.GetPrim().SetInstanceable(True)
    scene = usd.load()
    assert sorted({round(float(x)) for x in world(scene)[:, 0, 0]}) == [0, 10, 20]


def instancer(usd: UsdFile, path: str = "/Many") -> UsdGeom.PointInstancer:
    many = UsdGeom.PointInstancer.Define(usd.stage, path)
    usd.mesh(f"{path}/Square")
    many.CreatePrototypesRel().SetTargets([f"{path}/Square"])
    many.CreateProtoIndicesAttr([0, 0, 0])
    many.CreatePositionsAttr([(0, 0, 0), (10, 0, 0), (20, 0, 0)])
    return many


def test_point_instances(usd: UsdFile) -> None:
    many = instancer(usd)
    many.CreateScalesAttr([(1, 1, 1), (2, 2, 2), (1, 1, 1)])
    many.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0)] * 3)
    many.CreateIdsAttr([7, 8, 9])
    many.CreateInvisibleIdsAttr([9])
    many.AddTranslateOp().Set((0, 3, 0))
    UsdGeom.Xformable(usd.stage.GetPrimAtPath("/Many/Square")).AddTranslateOp().Set((0, 0, 1))
    corners = world(usd.load())
    assert len(corners) == 4
    assert np.allclose(corners[:2].reshape(-1, 3).min(axis=0), (0, 3, 1), atol=1e-5)
    assert np.allclose(corners[2:].reshape(-1, 3).max(axis=0), (12, 5, 2), atol=1e-5)


@pytest.mark.parametrize(("indices", "problem"), [([0, 0, 9], "protoIndices"), ([0, 0], "transforms of")])
def test_broken_point_instances(usd: UsdFile, indices: list[int], problem: str) -> None:
    instancer(usd).GetProtoIndicesAttr().Set(indices)
    with pytest.raises(SceneError, match=problem):
        usd.load()


def test_an_instancer_that_is_its_own_prototype(usd: UsdFile) -> None:
    many = instancer(usd)
    many.CreateProtoIndicesAttr([0])
    many.CreatePositionsAttr([(0, 0, 0)])
    many.GetPrototypesRel().SetTargets(["/Many"])
    with pytest.raises(SceneError, match="nested more than"):
        usd.load()


def test_what_is_not_to_be_seen(usd: UsdFile) -> None:
    usd.mesh("/Shown")
    usd.mesh("/Hidden/Mesh")
    UsdGeom.Xform.Define(usd.stage, "/Hidden").CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    for purpose in ("guide", "proxy", "render"):
        usd.mesh(f"/{purpose}").CreatePurposeAttr(purpose)
    usd.stage.CreateClassPrim("/Abstract")
    usd.mesh("/Abstract/Mesh")
    usd.mesh("/Inactive").GetPrim().SetActive(False)
    scene = usd.load()
    assert len(scene.triangles) == 4
    assert set(scene.report.ignored) == {
        "/Hidden: invisible prims were left out",
        "/guide: guides and proxies were left out (likewise /proxy)",
    }


def test_a_transform_that_is_not_finite(usd: UsdFile) -> None:
    usd.mesh().AddScaleOp().Set((float("nan"), 1, 1))
    with pytest.raises(SceneError, match="/Mesh: its transform"):
        usd.load()

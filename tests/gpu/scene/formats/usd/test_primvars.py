import numpy as np
import pytest
from usd_file import UsdFile

pytest.importorskip("pxr")
from gpu.scene.formats.usd.primvars import Topology, Values

# Two triangles that share an edge.
TOPOLOGY = Topology(np.array([0, 1, 2, 2, 1, 3]), np.array([3, 3]), 4)


@pytest.mark.parametrize(
    ("interpolation", "values", "by_corner"),
    [
        ("constant", [5], [5, 5, 5, 5, 5, 5]),
        ("uniform", [1, 2], [1, 1, 1, 2, 2, 2]),
        ("vertex", [0, 1, 2, 3], [0, 1, 2, 2, 1, 3]),
        ("varying", [0, 1, 2, 3], [0, 1, 2, 2, 1, 3]),
        ("faceVarying", [9, 8, 7, 6, 5, 4], [9, 8, 7, 6, 5, 4]),
    ],
)
def test_values_at_corners(interpolation: str, values: list[float], by_corner: list[float]) -> None:
    found = Values(np.array(values, float)[:, None], interpolation)
    assert TOPOLOGY.fits(found)
    assert TOPOLOGY.spread(found, True)[:, 0].tolist() == by_corner
    assert found.by_corner == (interpolation in ("uniform", "faceVarying"))
    if not found.by_corner:
        assert len(TOPOLOGY.spread(found, False)) == 4
    if interpolation != "constant":
        assert not TOPOLOGY.fits(Values(found.rows[:-1], interpolation))


def test_indexed_and_inherited_values(usd: UsdFile) -> None:
    usd.stage.DefinePrim("/Above", "Xform")
    mesh = usd.mesh("/Above/Mesh")
    usd.primvar(usd.stage.GetPrimAtPath("/Above"), "displayColor", "Color3fArray", "constant", [(0.5, 0.25, 0.125)])
    usd.primvar(mesh, "displayOpacity", "FloatArray", "faceVarying", [1.0, 0.5])
    from pxr import UsdGeom

    UsdGeom.PrimvarsAPI(mesh).GetPrimvar("displayOpacity").SetIndices([0, 1, 1, 0])
    colors = usd.load().colors
    assert np.allclose(colors[:, :3], (0.5, 0.25, 0.125))
    assert sorted(set(colors[:, 3].tolist())) == [0.5, 1.0]


@pytest.mark.parametrize("values", [[(1, 0, 0)] * 3, [(np.nan, 0, 0)] * 4])
def test_values_that_do_not_fit_are_said(usd: UsdFile, values: list) -> None:
    mesh = usd.mesh()
    usd.primvar(mesh, "displayColor", "Color3fArray", "vertex", values)
    scene = usd.load()
    assert scene.colors is None
    assert "/Mesh: values of displayColor that do not fit their mesh were left out" in scene.report.ignored

from math import pi

import numpy as np
import pytest
from usd_file import UsdFile, facing, world

pytest.importorskip("pxr")
from pxr import UsdGeom

AREAS = {
    "Cube": ({"size": 3.0}, 54.0, (1.5, 1.5, 1.5)),
    "Sphere": ({"radius": 2.0}, 16.0 * pi, (2.0, 2.0, 2.0)),
    "Cylinder": ({"radius": 1.0, "height": 3.0, "axis": "X"}, 8.0 * pi, (1.5, 1.0, 1.0)),
    "Cone": ({"radius": 3.0, "height": 4.0, "axis": "Y"}, 24.0 * pi, (3.0, 2.0, 3.0)),
    "Capsule": ({"radius": 1.0, "height": 2.0, "axis": "Z"}, 8.0 * pi, (1.0, 1.0, 2.0)),
    "Plane": ({"width": 2.0, "length": 6.0, "axis": "Y"}, 12.0, (1.0, 0.0, 3.0)),
}


@pytest.mark.parametrize("kind", AREAS)
def test_areas_and_extents(usd: UsdFile, kind: str) -> None:
    attributes, area, extent = AREAS[kind]
    prim = getattr(UsdGeom, kind).Define(usd.stage, "/Shape").GetPrim()
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    scene = usd.load()
    assert np.linalg.norm(facing(scene), axis=1).sum() / 2.0 == pytest.approx(area, rel=5e-3)
    assert np.allclose(np.abs(world(scene)).reshape(-1, 3).max(axis=0), extent, rtol=2e-3, atol=1e-6)
    if kind != "Plane":  # all faces look outwards, and so do the normals
        outwards = facing(scene)
        assert (np.einsum("tc,tc->t", outwards, world(scene).mean(axis=1)) > 0.0).all()
        normals = scene.normals[scene.triangles].mean(axis=1)
        assert (np.einsum("tc,tc->t", outwards, normals) > 0.0).all()
    assert scene.report.dropped_triangles == 0


def test_a_plane_faces_along_its_axis(usd: UsdFile) -> None:
    UsdGeom.Plane.Define(usd.stage, "/Plane").CreateAxisAttr("X")
    assert (facing(usd.load())[:, 0] > 0.0).all()

import numpy as np
import pytest
from ifc_file import House

from gpu.scene.formats.ifc.geometry import Geometry
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.parts import MOST_ID

geom = pytest.importorskip("ifcopenshell.geom", reason="the extra ifc is not installed")


def test_curved_surfaces_have_their_own_normals() -> None:
    house = House()
    column = house.extruded(
        "IfcColumn", house.make("IfcCircleProfileDef", "AREA", None, None, 500.0), 3000.0, (0, 0, 0)
    )
    geometry = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS)
    (part,) = geometry.parts([column])
    assert part.normals is not None
    side = np.abs(part.normals[:, 2]) < 0.5
    normals = part.normals[side] / np.linalg.norm(part.normals[side], axis=1, keepdims=True)
    assert np.allclose(normals[:, :2], part.positions[side, :2] / 500.0, atol=1e-6)
    assert geometry.metres_per_unit == 0.001


def test_a_mapped_item_is_placed_where_it_is_used() -> None:
    house = House()
    block = house.block("IfcBeam", (100.0, 100.0, 100.0), (0.0, 0.0, 0.0))
    shape = block.Representation.Representations[0]
    source = house.make(
        "IfcRepresentationMap", house.make("IfcAxis2Placement3D", house.make("IfcCartesianPoint", (0.0,) * 3)), shape
    )
    moved = house.make(
        "IfcCartesianTransformationOperator3D", None, None, house.make("IfcCartesianPoint", (0.0, 0.0, 700.0))
    )
    mapped = house.product(
        "IfcBeam", house.make("IfcMappedItem", source, moved), "MappedRepresentation", (1000.0, 0.0, 0.0)
    )
    (part,) = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS).parts([mapped])
    assert np.allclose(part.positions.min(axis=0), (1000, 0, 700))
    assert np.allclose(part.positions.max(axis=0), (1100, 100, 800))


def test_no_products_are_no_parts() -> None:
    assert Geometry("a.ifc", geom, House().model, DEFAULT_LIMITS).parts([]) == []


def test_products_of_one_name_are_objects_of_their_own() -> None:
    house = House()
    walls = [house.block("IfcWall", (100.0, 100.0, 100.0), (0.0, 0.0, low)) for low in (0.0, 200.0, 400.0)]
    walls[0].Name = walls[1].Name = "Basic wall: brick and render, 365 mm, both sides"
    parts = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS).parts(walls)
    names = [part.owners[0][0] for part in parts]
    assert names == [
        *(f"Basic wall: brick and render,… (IfcWall {wall.GlobalId})" for wall in walls[:2]),
        f"IfcWall {walls[2].GlobalId}",
    ]
    assert all(len(name) <= MOST_ID for name in names)

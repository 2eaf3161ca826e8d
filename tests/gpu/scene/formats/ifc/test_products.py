import pytest
from ifc_file import House

from gpu.errors import SceneError
from gpu.scene.formats.ifc.products import choose_products, storey_of

pytest.importorskip("ifcopenshell", reason="the extra ifc is not installed")


def test_parts_belong_to_the_storey_of_their_whole() -> None:
    house = House()
    window = house.model.by_type("IfcWindow")[1]
    stair, flight = house.rooted("IfcStair"), house.block("IfcStairFlight", (100, 100, 100), (0, 0, 0))
    house.aggregate(stair, flight)
    house.rooted("IfcRelContainedInSpatialStructure", RelatingStructure=house.storeys[1], RelatedElements=[stair])
    assert storey_of(window) == storey_of(flight) == house.storeys[1]
    assert storey_of(house.site) is None


def test_wholes_in_a_circle_are_in_no_storey() -> None:
    house = House()
    one, other = (house.block("IfcBeam", (100, 100, 100), (0, 0, 0)) for _ in range(2))
    house.aggregate(one, other)
    house.aggregate(other, one)
    assert storey_of(one) is None


def test_storeys_are_listed_from_the_lowest_if_they_have_elements() -> None:
    house = House()
    house.storeys[0].Elevation = 9000.0
    house.aggregate(house.building, house.rooted("IfcBuildingStorey", "empty"))
    assert choose_products("a.ifc", house.model, ()).storeys == ("level 1", "level 0")
    house.storeys[0].Name = None
    assert choose_products("a.ifc", house.model, ()).storeys == ("level 1", house.storeys[0].GlobalId)


def test_a_choice_of_storeys_leaves_out_what_is_in_none() -> None:
    house = House()
    house.block("IfcBuildingElementProxy", (100, 100, 100), (0, 0, 0))
    chosen = choose_products("a.ifc", house.model, ("level 0", "level 1"))
    assert len(chosen.shown) == 6
    assert "elements outside the chosen storeys, not shown: 1" in chosen.sentences


def test_a_model_without_storeys_has_none_to_choose() -> None:
    house = House()
    for storey in house.storeys:
        house.model.remove(storey)
    with pytest.raises(SceneError, match="no storey is called level 0; the file has none"):
        choose_products("a.ifc", house.model, ("level 0",))


def test_what_is_no_body_is_counted() -> None:
    house = House()
    line = house.make("IfcPolyline", [house.make("IfcCartesianPoint", at) for at in ((0.0, 0.0), (1.0, 0.0))])
    house.product("IfcAnnotation", line, "Curve2D", identifier="Annotation")
    house.product("IfcWall", line, "Curve2D", identifier="Axis")
    chosen = choose_products("a.ifc", house.model, ())
    assert len(chosen.shown) == 6
    assert chosen.sentences == [
        "what is no body is not shown: 1 IfcAnnotation, 2 IfcOpeningElement, 2 IfcSpace",
        "elements with an axis or an outline but no body, not shown: 1",
    ]

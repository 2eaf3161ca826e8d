import pytest
from ifc_file import House

from gpu.scene.formats.ifc.georeference import georeference

pytest.importorskip("ifcopenshell", reason="the extra ifc is not installed")


def test_a_map_conversion_is_told() -> None:
    house = House()
    crs = house.make("IfcProjectedCRS", "EPSG:7856")
    place = (335087.17, 6251635.41, 5.0, 0.0, 1.0)
    house.make("IfcMapConversion", house.context, crs, *place)
    assert georeference(house.model) == [
        "the file's origin is at easting 335087.17, northing 6251635.41, height 5 of EPSG:7856, "
        "its x axis turned 90° from east to north"
    ]


def test_the_property_set_of_ifc2x3_is_told() -> None:
    house = House("IFC2X3")
    values = {"Eastings": 1200.5, "Northings": 30.0, "Scale": 0.9996}
    properties = [
        house.make("IfcPropertySingleValue", name, None, house.make("IfcReal", value)) for name, value in values.items()
    ]
    house.rooted("IfcPropertySet", "ePset_MapConversion", HasProperties=properties)
    assert georeference(house.model) == [
        "the file's origin is at easting 1200.5, northing 30, height 0 of an unnamed map, scaled by 0.9996"
    ]


def test_the_latitude_of_a_site_is_told() -> None:
    house = House()
    assert georeference(house.model) == []
    house.site.RefLatitude, house.site.RefLongitude = (-33, -51, -36), (151, 12, 0, 500000)
    assert georeference(house.model) == ["the site site is at latitude -33.86°, longitude 151.2001°"]

import pytest
from ifc_file import House

from gpu.scene.formats.ifc.unshown import unshown_kinds

pytest.importorskip("ifcopenshell", reason="the extra ifc is not installed")


@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4", "IFC4X3"])
def test_a_house_says_nothing_that_is_not_shown(schema: str) -> None:
    assert unshown_kinds(House(schema).model) == []


def test_lights_and_textures_are_counted() -> None:
    house = House()
    for _ in range(2):
        house.block("IfcLightFixture", (100.0, 100.0, 100.0), (0.0, 0.0, 0.0))
    house.make("IfcLightSourceAmbient", None, house.make("IfcColourRgb", None, 1.0, 1.0, 1.0))
    house.make("IfcSurfaceStyleWithTextures", [house.make("IfcImageTexture", True, True, URLReference="a.png")])
    assert unshown_kinds(house.model) == [
        "light sources (IfcLightSource) are not supported and give no light: 1",
        "light fixtures (IfcLightFixture) are shown but give no light: 2",
        "textures of styles are not supported; their colours count: 1",
    ]

from typing import Any

import pytest
from ifc_file import House

from gpu.scene.formats.ifc.geometry import Geometry
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.types import Material

geom = pytest.importorskip("ifcopenshell.geom", reason="the extra ifc is not installed")


def material(house: House, style: Any) -> Material:
    """What a block with `style` becomes."""
    block = house.block("IfcBeam", (100.0, 100.0, 100.0), (0.0, 0.0, 0.0), style)
    geometry = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS)
    (part,) = geometry.parts([block])
    return geometry.styles.materials[part.material]


@pytest.mark.parametrize(
    ("kind", "value", "method", "expected"),
    [
        (None, None, "NOTDEFINED", (0.0, 1.0, 0.0)),
        ("IfcSpecularRoughness", 0.3, "NOTDEFINED", (1.0, 0.3, 0.0)),
        ("IfcSpecularExponent", 30.0, "NOTDEFINED", (1.0, 0.5, 0.0)),
        ("IfcSpecularRoughness", 0.3, "METAL", (1.0, 0.3, 1.0)),
        (None, None, "METAL", (1.0, 1.0, 1.0)),
        (None, None, "MIRROR", (1.0, 0.0, 1.0)),
    ],
)
def test_highlights(kind: str | None, value: float | None, method: str, expected: tuple[float, float, float]) -> None:
    house = House()
    highlight = {} if kind is None else {"SpecularHighlight": house.make(kind, value)}
    found = material(house, house.style("a", (1.0, 1.0, 1.0), ReflectanceMethod=method, **highlight))
    assert (found.specular, found.roughness, found.metallic) == pytest.approx(expected)


def test_a_diffuse_factor_scales_the_colour() -> None:
    house = House()
    factor = house.make("IfcNormalisedRatioMeasure", 0.5)
    assert material(house, house.style("a", (1.0, 0.0, 0.0), DiffuseColour=factor)).base_color == pytest.approx(
        (0.214041, 0.0, 0.0, 1.0), abs=1e-5
    )


def test_refraction_is_an_index() -> None:
    house = House()
    style = house.style("a", (1.0, 0.0, 0.0))
    style.Styles = [*style.Styles, house.make("IfcSurfaceStyleRefraction", 1.3)]
    assert material(house, style).ior == pytest.approx(1.3)


def test_a_style_of_several_elements_is_one_material() -> None:
    house = House()
    geometry = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS)
    geometry.parts(house.model.by_type("IfcWall") + house.model.by_type("IfcSlab"))
    assert [found.name for found in geometry.styles.materials] == ["plaster", "IfcSlab"]


def test_a_material_with_a_style_counts() -> None:
    house = House()
    slab = house.model.by_type("IfcSlab")[0]
    stone = house.make("IfcMaterial", "stone")
    house.rooted("IfcRelAssociatesMaterial", RelatedObjects=[slab], RelatingMaterial=stone)
    geometry = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS)
    (part,) = geometry.parts([slab])
    assert geometry.styles.materials[part.material].base_color[:3] != (0.0, 0.0, 0.0)
    item = house.make("IfcStyledItem", None, [house.plaster])
    styled = house.make("IfcStyledRepresentation", house.context, "Style", "Material", [item])
    house.make("IfcMaterialDefinitionRepresentation", None, None, [styled], stone)
    geometry = Geometry("a.ifc", geom, house.model, DEFAULT_LIMITS)
    (part,) = geometry.parts([slab])
    assert geometry.styles.materials[part.material].name == "plaster"

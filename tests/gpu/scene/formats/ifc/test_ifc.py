"""Whole IFC files, as load_ifc reads them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ifc_file import COLOR, House

from gpu.errors import SceneError
from gpu.scene.formats.ifc import load_ifc
from gpu.scene.import_options import ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import AlphaMode, Scene

pytest.importorskip("ifcopenshell", reason="the extra ifc is not installed")


def load(folder: Path, house: House, limits: SceneLimits = DEFAULT_LIMITS, **options: Any) -> Scene:
    path = folder / "house.ifc"
    path.write_bytes(house.bytes())
    return load_ifc(path, limits, ImportOptions(**options))


def bounds(scene: Scene) -> list[list[float]]:
    world = scene.vertices.astype(np.float64) / scene.placement.scale + np.array(scene.placement.centre)
    return [[round(float(value), 4) + 0.0 for value in bound] for bound in (world.min(axis=0), world.max(axis=0))]


@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4", "IFC4X3"])
def test_a_house_is_shown_in_metres_with_its_openings_cut(tmp_path: Path, schema: str) -> None:
    scene = load(tmp_path, House(schema))
    assert bounds(scene) == [[0, -0.2, -4], [4, 6, 0]]
    assert [material.name for material in scene.materials] == ["plaster", "glass", "IfcSlab"]
    # A box has 12 triangles, a wall with a hole through it 32.
    assert np.bincount(scene.triangle_material).tolist() == [64, 24, 24]
    corners = scene.vertices[scene.triangles[scene.triangle_material == 0]] / scene.placement.scale
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    assert normals[np.abs(normals[:, 2]) > 0, 2].clip(0).sum() == pytest.approx(2 * (12.0 - 1.0), rel=1e-4)
    assert scene.report.ignored == ("what is no body is not shown: 2 IfcOpeningElement, 2 IfcSpace",)
    assert "elements without a style, which have a colour by their type: 2" in scene.report.notes


def test_styles_are_materials(tmp_path: Path) -> None:
    plaster, glass, slab = load(tmp_path, House()).materials
    assert plaster.base_color == pytest.approx((*(((level + 0.055) / 1.055) ** 2.4 for level in COLOR), 1.0))
    assert (plaster.alpha_mode, plaster.specular, plaster.double_sided) == (AlphaMode.OPAQUE, 0.0, True)
    assert (glass.alpha_mode, glass.base_color[3]) == (AlphaMode.BLEND, 0.25)
    assert slab.alpha_mode is AlphaMode.OPAQUE


def test_storeys_are_a_choice(tmp_path: Path) -> None:
    house = House()
    scene = load(tmp_path, house)
    assert scene.choices == {"storey": ("level 0", "level 1")}
    upper = load(tmp_path, house, storeys=("level 1",))
    assert bounds(upper) == [[0, 2.8, -4], [4, 6, 0]]
    assert upper.choices == scene.choices
    assert "elements outside the chosen storeys, not shown: 3" in upper.report.ignored
    with pytest.raises(SceneError, match="storeys: no storey is called attic; there are level 0, level 1"):
        load(tmp_path, house, storeys=("level 0", "attic"))


def test_coordinates_of_a_survey_keep_their_precision(tmp_path: Path) -> None:
    far = (335087170.0, 6251635410.0, 5000.0)
    scene = load(tmp_path, House(at=far))
    assert bounds(scene) == pytest.approx(np.array([[335087.17, 4.8, -6251639.41], [335091.17, 11.0, -6251635.41]]))
    near = load(tmp_path, House())
    assert np.abs(scene.vertices - near.vertices).max() < 1e-6
    moved = load(tmp_path, House(at=far), origin=far)
    assert bounds(moved) == bounds(near)


def test_the_unit_of_a_user_counts(tmp_path: Path) -> None:
    assert bounds(load(tmp_path, House(), unit="m")) == pytest.approx(
        np.array([[0, -200, -4000], [4000, 6000, 0]]), abs=1e-3
    )


def test_elements_that_cannot_be_converted_are_named(tmp_path: Path) -> None:
    house = House()
    broken = house.block("IfcBeam", (100.0, 100.0, 100.0), (0.0, 0.0, 0.0))
    broken.Representation.Representations[0].Items[0].Depth = -1.0
    scene = load(tmp_path, house)
    assert len(scene.triangles) == 112
    assert f"elements whose geometry cannot be converted, left out: 1 ({broken.GlobalId})" in scene.report.ignored


def test_limits_count_before_all_is_converted(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="max_triangles"):
        load(tmp_path, House(), SceneLimits(max_triangles=40))


def test_a_model_without_bodies_is_refused(tmp_path: Path) -> None:
    house = House()
    for product in house.model.by_type("IfcProduct"):
        product.Representation = None
    with pytest.raises(SceneError, match="no triangles"):
        load(tmp_path, house)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"IFCRELFILLSELEMENT('", b"IFCRELFILLSELEMENT($,'"),
        (b"IFCPRODUCTDEFINITIONSHAPE($,$,(#", b"IFCPRODUCTDEFINITIONSHAPE($,$,(#1,#"),
        (b"IFCSURFACESTYLE('plaster',.BOTH.,(#", b"IFCSURFACESTYLE('plaster',.BOTH.,(#1,#"),
        (b".ELEMENT.,0.)", b".ELEMENT.,'high')"),
    ],
)
def test_a_reference_to_another_kind_is_no_traceback(tmp_path: Path, old: bytes, new: bytes) -> None:
    content = House().bytes()
    assert old in content
    path = tmp_path / "a.ifc"
    path.write_bytes(content.replace(old, new, 1))
    try:
        said = load_ifc(path).report.ignored
    except SceneError as error:
        said = (error.problem,)
    assert any("is not as its schema says" in text or "left out" in text or "no body" in text for text in said)

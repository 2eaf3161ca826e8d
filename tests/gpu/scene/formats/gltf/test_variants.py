import pytest
from gltf_file import GltfFile

from gpu.errors import SceneError
from gpu.scene.formats.gltf import load_gltf
from gpu.scene.import_options import ImportOptions
from gpu.scene.types import Scene


def variants(gltf: GltfFile) -> None:
    for name in ("own", "red", "blue"):
        gltf.add("materials", name=name)
    mappings = [{"material": 1, "variants": [0]}, {"material": 2, "variants": [1, 2]}]
    gltf.mesh_node(gltf.primitive(material=0, extensions={"KHR_materials_variants": {"mappings": mappings}}))
    names = [{"name": "warm"}, {"name": "cold"}, {"name": "colder"}, {"name": "unused"}]
    gltf.json["extensions"] = {"KHR_materials_variants": {"variants": names}}
    gltf.json["extensionsUsed"] = ["KHR_materials_variants"]


def shown(scene: Scene) -> str:
    return scene.materials[scene.triangle_material[0]].name


@pytest.mark.parametrize(
    ("wanted", "material"), [(None, "own"), ("warm", "red"), ("cold", "blue"), ("colder", "blue"), ("unused", "own")]
)
def test_a_variant_is_shown(gltf: GltfFile, wanted: str | None, material: str) -> None:
    variants(gltf)
    scene = load_gltf(gltf.write(), options=ImportOptions(variant=wanted))
    assert shown(scene) == material
    assert list(scene.choices["variant"]) == ["warm", "cold", "colder", "unused"]
    assert not scene.report.ignored


def test_a_variant_that_is_not_there(gltf: GltfFile) -> None:
    variants(gltf)
    with pytest.raises(SceneError, match="no variant 'hot' in it; it has warm, cold, colder, unused"):
        load_gltf(gltf.write(), options=ImportOptions(variant="hot"))


def test_a_file_without_variants(gltf: GltfFile) -> None:
    gltf.mesh_node()
    path = gltf.write()
    assert not load_gltf(path).choices
    with pytest.raises(SceneError, match="no variant 'hot' in it; it has none"):
        load_gltf(path, options=ImportOptions(variant="hot"))


@pytest.mark.parametrize("broken", [5, {"variants": 3}, {"variants": [None, {"name": 7}]}])
def test_broken_variants_leave_the_materials_as_they_are(gltf: GltfFile, broken: object) -> None:
    variants(gltf)
    gltf.json["extensions"]["KHR_materials_variants"] = broken
    scene = gltf.load()
    assert shown(scene) == "own"
    assert any("KHR_materials_variants" in note for note in scene.report.notes)

import numpy as np
import pytest
from gltf_file import UV, GltfFile, image

VALUES = np.zeros((3, 4), np.float32)


def test_a_key_that_is_not_known_is_said_once(gltf: GltfFile) -> None:
    for _ in range(3):
        gltf.mesh_node(layer="roof")
    gltf.json["materials"] = [{"pbrMetallicRoughness": {"gloss": 1}}]
    assert gltf.load().report.ignored == (
        "nodes[].layer is not used (3)",
        "materials[].pbrMetallicRoughness.gloss is not used (1)",
    )


@pytest.mark.parametrize("name", ["COLOR_1", "TEXCOORD_1", "_BATCHID"])
def test_attributes_that_no_surface_has_are_said(gltf: GltfFile, name: str) -> None:
    gltf.mesh_node(gltf.primitive(TEXCOORD_0=UV), gltf.primitive())
    gltf.json["meshes"][0]["primitives"][1]["attributes"][name] = gltf.accessor(VALUES)
    assert gltf.load().report.ignored == (f"meshes[].primitives[].attributes.{name} is not used (1)",)


@pytest.mark.parametrize("normal_map", [True, False])
def test_tangents_are_said_where_there_is_a_normal_map(gltf: GltfFile, normal_map: bool) -> None:
    gltf.add("textures", source=image(gltf))
    gltf.add("materials", **({"normalTexture": {"index": 0}} if normal_map else {}))
    gltf.mesh_node(gltf.primitive(material=0, TEXCOORD_0=UV, TANGENT=VALUES))
    assert gltf.load().report.ignored == ("meshes[].primitives[].attributes.TANGENT is not used (1)",) * normal_map


def test_morph_targets_of_other_attributes_are_said(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(targets=[{"COLOR_0": gltf.accessor(VALUES)}]))
    assert gltf.load().report.ignored == ("meshes[].primitives[].targets[].COLOR_0 is not used (1)",)


def test_extensions_are_said_with_what_has_them_declared_or_not(gltf: GltfFile) -> None:
    gltf.json["extensionsUsed"] = ["EXT_materials_bump", "KHR_xmp", "KHR_materials_unlit"]
    for _ in range(2):
        gltf.add("materials", extensions={"EXT_materials_bump": {}, "KHR_materials_unlit": {}})
    gltf.mesh_node(extensions={"MSFT_lod": {"ids": [1]}})
    assert gltf.load().report.ignored == (
        "extension EXT_materials_bump is not supported and was ignored (2 materials)",
        "extension KHR_xmp is not supported and was ignored",
        "extension MSFT_lod is not supported and was ignored (1 nodes)",
    )


def test_light_around_that_is_left_out_is_said(gltf: GltfFile) -> None:
    gltf.json["extensionsUsed"] = ["EXT_lights_image_based"]
    gltf.json["extensions"] = {"EXT_lights_image_based": {"lights": [{"intensity": 1.0}]}}
    gltf.mesh_node()
    said = "extension EXT_lights_image_based is not supported and was ignored: the light around the scene is left out;"
    assert any(said in line for line in gltf.load().report.ignored)


def test_keys_of_extras_are_listed(gltf: GltfFile) -> None:
    gltf.mesh_node(extras={f"key{number}": 0 for number in range(10)})
    gltf.json["asset"]["extras"] = {"title": "house"}
    gltf.json["extras"] = "text"
    notes = gltf.load().report.notes
    assert "extras are not used: title, key0, key1, key2, key3, key4, key5, key6 and 3 more" in notes


def test_what_is_in_no_scene_is_counted(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.mesh_node()
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0})
    gltf.json["scenes"] = [{"nodes": [0]}]
    assert gltf.load().report.ignored == ("what is in no scene is not shown: 1 nodes, 1 meshes, 1 cameras",)


def test_a_file_of_all_that_is_known_says_nothing(gltf: GltfFile) -> None:
    gltf.json["asset"].update(generator="hand", copyright="none")
    gltf.add("samplers", magFilter=9729, minFilter=9987, wrapS=10497, wrapT=10497, name="s")
    gltf.add("textures", source=image(gltf), sampler=0, name="t")
    gltf.add("materials", name="m", normalTexture={"index": 0, "texCoord": 1, "scale": 2}, alphaMode="MASK")
    primitive = gltf.primitive(material=0, mode=4, TEXCOORD_0=UV)
    primitive["attributes"]["TEXCOORD_1"] = gltf.accessor(UV)
    gltf.mesh_node(primitive, name="n", translation=[0, 0, 1])
    gltf.json.update(scenes=[{"nodes": [0], "name": "all"}], scene=0)
    assert gltf.load().report.ignored == ()

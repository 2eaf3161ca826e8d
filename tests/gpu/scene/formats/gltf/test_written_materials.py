from dataclasses import replace
from typing import Any

import pytest

from gpu.scene.formats.gltf.written_materials import back_of, material_entry
from gpu.scene.types import AlphaMode, Material, TextureSlot


def test_a_plain_material_says_little() -> None:
    base = {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
    assert material_entry(Material("plain")) == {
        "name": "plain",
        "pbrMetallicRoughness": base,
        "emissiveFactor": [0.0, 0.0, 0.0],
        "alphaMode": "OPAQUE",
        "doubleSided": True,
    }


def test_light_of_more_than_one_is_a_factor_and_its_strength() -> None:
    entry = material_entry(Material(emission=(4.0, 2.0, 0.0)))
    assert entry["emissiveFactor"] == [1.0, 0.5, 0.0]
    assert entry["extensions"] == {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}}
    assert not entry["doubleSided"]  # a lamp whose file does not tell shines to its front
    assert material_entry(Material(emission=(0.5, 0.0, 0.0)))["emissiveFactor"] == [0.5, 0.0, 0.0]


def test_every_use_of_a_texture_is_written() -> None:
    slot = TextureSlot(3, 1)
    material = Material(
        emission=(1.0, 1.0, 1.0),
        metallic_roughness_slot=slot,
        emission_slot=slot,
        normal_slot=slot,
        normal_scale=2.0,
        transmission=0.5,
        transmission_slot=slot,
        clearcoat=0.5,
        clearcoat_slot=slot,
        clearcoat_roughness_slot=slot,
        clearcoat_normal_slot=slot,
        clearcoat_normal_scale=0.5,
        specular=0.5,
        specular_slot=slot,
        specular_color_slot=slot,
        sheen_color=(0.5, 0.0, 0.0),
        sheen_color_slot=slot,
        sheen_roughness_slot=slot,
        iridescence=0.5,
        iridescence_slot=slot,
        iridescence_thickness_slot=slot,
        anisotropy=0.5,
        anisotropy_slot=slot,
        diffuse_transmission=0.5,
        diffuse_transmission_slot=slot,
        diffuse_transmission_color_slot=slot,
    )
    entry = material_entry(material)
    use = {"index": 3, "texCoord": 1}
    coat = entry["extensions"]["KHR_materials_clearcoat"]
    assert entry["pbrMetallicRoughness"]["metallicRoughnessTexture"] == entry["emissiveTexture"] == use
    assert entry["normalTexture"] == {**use, "scale": 2.0}
    assert entry["extensions"]["KHR_materials_transmission"]["transmissionTexture"] == use
    assert coat["clearcoatTexture"] == coat["clearcoatRoughnessTexture"] == use
    assert coat["clearcoatNormalTexture"] == {**use, "scale": 0.5}
    specular = entry["extensions"]["KHR_materials_specular"]
    assert specular["specularTexture"] == specular["specularColorTexture"] == use
    sheen = entry["extensions"]["KHR_materials_sheen"]
    assert sheen["sheenColorTexture"] == sheen["sheenRoughnessTexture"] == use
    film = entry["extensions"]["KHR_materials_iridescence"]
    assert film["iridescenceTexture"] == film["iridescenceThicknessTexture"] == use
    assert entry["extensions"]["KHR_materials_anisotropy"]["anisotropyTexture"] == use
    through = entry["extensions"]["KHR_materials_diffuse_transmission"]
    assert through["diffuseTransmissionTexture"] == through["diffuseTransmissionColorTexture"] == use


def test_a_texture_is_moved_turned_and_scaled() -> None:
    slot = TextureSlot(0, 0, (2.0, 0.0, 0.5, 0.0, -3.0, 0.25))
    use = material_entry(Material(base_color_slot=slot))["pbrMetallicRoughness"]["baseColorTexture"]
    change = use["extensions"]["KHR_texture_transform"]
    assert change == {
        "offset": [0.5, 0.25],
        "rotation": pytest.approx(0.0),
        "scale": [2.0, -3.0],
    }


def test_glass_says_how_deep_light_goes() -> None:
    glass = material_entry(Material(transmission=1.0, thickness=0.1, attenuation_color=(0.5, 1.0, 1.0)))["extensions"]
    assert glass["KHR_materials_volume"] == {"thicknessFactor": 0.1, "attenuationColor": [0.5, 1.0, 1.0]}
    dark = material_entry(Material(transmission=1.0, thickness=0.1, attenuation_distance=0.02, ior=1.3))["extensions"]
    assert dark["KHR_materials_volume"]["attenuationDistance"] == 0.02
    assert dark["KHR_materials_ior"] == {"ior": 1.3}


@pytest.mark.parametrize(
    "told",
    [{"double_sided": True}, {"double_sided": False}, {"emission": (0.0, 0.0, 0.0)}, {"transmission": 0.5},
     {"alpha_mode": AlphaMode.BLEND}, {"unlit": True}],
)  # fmt: skip
def test_lamps_alone_that_tell_no_sides_have_a_back_of_its_own(told: dict[str, Any]) -> None:
    lamp = Material("lamp", emission=(1.0, 1.0, 1.0))
    assert back_of(lamp) == Material("lamp (back)", double_sided=False)
    assert back_of(replace(lamp, **told)) is None

"""Materials as glTF has them: metallic-roughness, with the extensions that gpu.scene.formats.gltf.materials reads."""

from dataclasses import replace
from math import atan2, hypot, isinf
from typing import Any

from gpu.scene.types import AlphaMode, Material, TextureSlot

_ALPHA_MODES = {AlphaMode.OPAQUE: "OPAQUE", AlphaMode.MASK: "MASK", AlphaMode.BLEND: "BLEND"}
_IDENTITY = TextureSlot(0).transform
_PLAIN = Material()


def back_of(material: Material) -> Material | None:
    """What is on the dark side of a lamp whose file does not tell sides, since glTF has no lamp that is seen from both
    and shines to its front alone.

    None where nothing is, as of glass and of what is there in part: it would be so twice.
    """
    whole = material.transmission == 0.0 and material.alpha_mode is not AlphaMode.BLEND
    if material.double_sided is not None or not material.emits or not whole:
        return None
    return replace(
        material,
        name=f"{material.name} (back)",
        emission=(0.0, 0.0, 0.0),
        emission_slot=None,
        double_sided=False,
        stays_light=False,
    )


def material_entry(material: Material) -> dict[str, Any]:
    """A material of the file's JSON; lengths are in metres."""
    base: dict[str, Any] = {
        "baseColorFactor": list(material.base_color),
        "metallicFactor": material.metallic,
        "roughnessFactor": material.roughness,
        **_info("baseColorTexture", material.base_color_slot),
        **_info("metallicRoughnessTexture", material.metallic_roughness_slot),
    }
    strength = max(*material.emission, 1.0)
    entry: dict[str, Any] = {
        "name": material.name,
        "pbrMetallicRoughness": base,
        "emissiveFactor": [value / strength for value in material.emission],
        **_info("emissiveTexture", material.emission_slot),
        "alphaMode": _ALPHA_MODES[material.alpha_mode],
        # Where a file did not tell, both sides are seen, but the front alone is a light: `back_of` has the other.
        "doubleSided": material.double_sided or (material.double_sided is None and not material.emits),
        "extensions": _extensions(material, strength),
    }
    if material.alpha_mode is AlphaMode.MASK:
        entry["alphaCutoff"] = material.alpha_cutoff
    entry |= _normal("normalTexture", material.normal_slot, material.normal_scale)
    return {name: part for name, part in entry.items() if part != {}}


def _extensions(material: Material, strength: float) -> dict[str, Any]:
    made: dict[str, Any] = {}
    if strength > 1.0:
        made["emissive_strength"] = {"emissiveStrength": strength}
    if material.unlit:
        made["unlit"] = {}
    if material.ior != _PLAIN.ior:
        made["ior"] = {"ior": material.ior}
    if material.dispersion > 0.0:
        made["dispersion"] = {"dispersion": material.dispersion}
    if material.transmission > 0.0:
        factor = {"transmissionFactor": material.transmission}
        made["transmission"] = factor | _info("transmissionTexture", material.transmission_slot)
    if material.thickness > 0.0:
        volume: dict[str, Any] = {
            "thicknessFactor": material.thickness,
            "attenuationColor": list(material.attenuation_color),
        }
        if not isinf(material.attenuation_distance):
            volume["attenuationDistance"] = material.attenuation_distance
        made["volume"] = volume
    specular: dict[str, Any] = {
        "specularFactor": material.specular,
        "specularColorFactor": list(material.specular_color),
        **_info("specularTexture", material.specular_slot),
        **_info("specularColorTexture", material.specular_color_slot),
    }
    if specular != {"specularFactor": _PLAIN.specular, "specularColorFactor": list(_PLAIN.specular_color)}:
        made["specular"] = specular
    if material.clearcoat > 0.0:
        coat_normal = _normal("clearcoatNormalTexture", material.clearcoat_normal_slot, material.clearcoat_normal_scale)
        made["clearcoat"] = {
            "clearcoatFactor": material.clearcoat,
            "clearcoatRoughnessFactor": material.clearcoat_roughness,
            **_info("clearcoatTexture", material.clearcoat_slot),
            **_info("clearcoatRoughnessTexture", material.clearcoat_roughness_slot),
            **coat_normal,
        }
    if max(material.sheen_color) > 0.0:
        made["sheen"] = {
            "sheenColorFactor": list(material.sheen_color),
            "sheenRoughnessFactor": material.sheen_roughness,
            **_info("sheenColorTexture", material.sheen_color_slot),
            **_info("sheenRoughnessTexture", material.sheen_roughness_slot),
        }
    if material.iridescence > 0.0:
        made["iridescence"] = {
            "iridescenceFactor": material.iridescence,
            "iridescenceIor": material.iridescence_ior,
            "iridescenceThicknessMinimum": material.iridescence_least,
            "iridescenceThicknessMaximum": material.iridescence_most,
            **_info("iridescenceTexture", material.iridescence_slot),
            **_info("iridescenceThicknessTexture", material.iridescence_thickness_slot),
        }
    if material.anisotropy > 0.0:
        made["anisotropy"] = {
            "anisotropyStrength": material.anisotropy,
            "anisotropyRotation": material.anisotropy_rotation,
            **_info("anisotropyTexture", material.anisotropy_slot),
        }
    if material.diffuse_transmission > 0.0:
        made["diffuse_transmission"] = {
            "diffuseTransmissionFactor": material.diffuse_transmission,
            "diffuseTransmissionColorFactor": list(material.diffuse_transmission_color),
            **_info("diffuseTransmissionTexture", material.diffuse_transmission_slot),
            **_info("diffuseTransmissionColorTexture", material.diffuse_transmission_color_slot),
        }
    return {f"KHR_materials_{name}": part for name, part in made.items()}


def _normal(name: str, slot: TextureSlot | None, scale: float) -> dict[str, Any]:
    """A use of a normal map under its name; nothing where there is none."""
    return {key: {**info, "scale": scale} for key, info in _info(name, slot).items()}


def _info(name: str, slot: TextureSlot | None) -> dict[str, Any]:
    """A use of a texture under its name; nothing where there is none. A shear of its UVs is left out (there is none in
    KHR_texture_transform).
    """
    if slot is None:
        return {}
    info: dict[str, Any] = {"index": slot.texture, "texCoord": slot.uv_set}
    if slot.transform != _IDENTITY:
        uu, uv, u, vu, vv, v = slot.transform
        su = hypot(uu, vu)
        change = {
            "offset": [u, v],
            "rotation": atan2(-vu, uu),
            "scale": [su, (uu * vv - uv * vu) / su if su > 0.0 else hypot(uv, vv)],
        }
        info["extensions"] = {"KHR_texture_transform": change}
    return {name: info}

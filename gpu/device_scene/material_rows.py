"""Materials and textures as kernels read them: rows of numbers, and texels one behind the other."""

from math import cos, sin
from typing import Any

import numpy as np

from gpu.core.device import layout_of
from gpu.device_scene.data import (
    BASE_COLOR,
    COAT,
    COAT_NORMAL,
    COAT_ROUGHNESS,
    EMISSION,
    FILM,
    FILM_THICKNESS,
    GRAIN,
    METALLIC_ROUGHNESS,
    NORMAL,
    SHEEN_COLOR,
    SHEEN_ROUGHNESS,
    SPECULAR,
    SPECULAR_COLOR,
    THROUGH,
    THROUGH_COLOR,
    TRANSMISSION,
    MaterialData,
    SlotData,
    TextureData,
)
from gpu.scene.types import AlphaMode, Doubles, Material, Texture, TextureSlot

_LEAST_TRANSMITTANCE = 1e-6  # of a black attenuation colour, whose absorption would be infinite
_MATERIAL = layout_of(MaterialData)
# What materials and their rows call the same.
_SAME = ("base_color", "emission", "metallic", "roughness", "ior", "dispersion", "specular", "specular_color",
         "transmission", "normal_scale", "unlit", "sheen_color", "sheen_roughness")  # fmt: skip
_SLOT = layout_of(SlotData)


def _slots(material: Material) -> list[tuple[int, TextureSlot]]:
    """What its textures are for, and these."""
    uses = {
        BASE_COLOR: material.base_color_slot,
        EMISSION: material.emission_slot,
        METALLIC_ROUGHNESS: material.metallic_roughness_slot,
        NORMAL: material.normal_slot,
        TRANSMISSION: material.transmission_slot,
        SPECULAR: material.specular_slot,
        SPECULAR_COLOR: material.specular_color_slot,
        SHEEN_COLOR: material.sheen_color_slot,
        SHEEN_ROUGHNESS: material.sheen_roughness_slot,
        FILM: material.iridescence_slot,
        FILM_THICKNESS: material.iridescence_thickness_slot,
        GRAIN: material.anisotropy_slot,
        THROUGH: material.diffuse_transmission_slot,
        THROUGH_COLOR: material.diffuse_transmission_color_slot,
        COAT: material.clearcoat_slot,
        COAT_ROUGHNESS: material.clearcoat_roughness_slot,
        COAT_NORMAL: material.clearcoat_normal_slot,
    }
    return [(int(use), slot) for use, slot in uses.items() if slot is not None]


def _absorption(material: Material, units_per_length: float) -> Doubles:
    """Beer's law for the inside of a material [1/unit length] (KHR_materials_volume, Attenuation).

    units_per_length: unit lengths in one of the file's.
    """
    colour = np.maximum(material.attenuation_color, _LEAST_TRANSMITTANCE)
    return np.asarray(-np.log(colour) / (material.attenuation_distance * units_per_length))


def _set_material(row: Any, material: Material, units_per_length: float) -> None:
    """Have a row of MaterialData, all zero, say what `material` is."""
    for name in _SAME:
        row[name] = getattr(material, name)
    row["thin"], row["absorption"] = material.thickness == 0.0, _absorption(material, units_per_length)
    row["alpha_cutoff"], row["blend"] = material.solid_alpha, material.alpha_mode is AlphaMode.BLEND
    row["part_glass"] = material.is_part_glass
    row["coat"], row["coat_roughness"] = material.clearcoat, material.clearcoat_roughness
    row["coat_normal_scale"] = material.clearcoat_normal_scale
    row["film"], row["film_ior"] = material.iridescence, material.iridescence_ior
    row["film_least"], row["film_most"] = material.iridescence_least, material.iridescence_most
    row["grain"], row["grain_set"] = material.anisotropy, material.grain_set
    row["grain_turn"] = cos(material.anisotropy_rotation), sin(material.anisotropy_rotation)
    row["through"], row["through_color"] = material.diffuse_transmission, material.diffuse_transmission_color
    row["double_sided"] = bool(material.double_sided)


def texture_rows(textures: tuple[Texture, ...]) -> tuple[list[TextureData], np.ndarray]:
    """The textures' descriptions, and all their texels one behind the other; equal images are stored once."""
    places: dict[int, int] = {}
    chunks: list[np.ndarray] = []
    total = 0
    entries = []
    for texture in textures:
        if id(texture.pixels) not in places:
            places[id(texture.pixels)] = total
            chunks.append(np.ascontiguousarray(texture.pixels).view("<u4").ravel())
            total += chunks[-1].size
        entry = TextureData()
        entry.first = places[id(texture.pixels)]
        entry.height, entry.width = texture.pixels.shape[:2]
        entry.srgb, entry.nearest = texture.srgb, texture.nearest
        entry.wrap_s, entry.wrap_t = int(texture.wrap_s), int(texture.wrap_t)
        entries.append(entry)
    return entries, np.concatenate(chunks) if chunks else np.zeros(1, np.uint32)


def material_rows(
    materials: tuple[Material, ...],
    units_per_length: float,
    known: tuple[tuple[Material, ...], np.ndarray] | None = None,
) -> np.ndarray:
    """Rows of MaterialData, a material each.

    known: other materials and their rows, of which most are the same; they have the same textures. units_per_length:
    unit lengths in one of the file's.
    """
    changed = [*range(len(materials))]
    if known is None:
        rows = np.zeros(len(changed), _MATERIAL)
        slots = np.array([len(_slots(material)) for material in materials], np.int32)
        first_slot = np.cumsum(slots) - slots
    else:
        others, rows = known[0], known[1].copy()
        changed = [number for number in changed if materials[number] is not others[number]]
        slots, first_slot = rows["slots"].copy(), rows["first_slot"].copy()
    rows[changed] = np.zeros(1, _MATERIAL)
    for number in changed:
        _set_material(rows[number], materials[number], units_per_length)
    rows["slots"], rows["first_slot"] = slots, first_slot
    return rows


def slot_rows(materials: tuple[Material, ...]) -> np.ndarray:
    """Rows of SlotData: all uses of textures, a material's after those of the one before; one at least."""
    slots = [slot for material in materials for slot in _slots(material)]
    rows = np.zeros(max(len(slots), 1), _SLOT)
    for row, (use, slot) in zip(rows, slots, strict=False):
        row["use"], row["texture"], row["uv_set"] = use, slot.texture, slot.uv_set
        row["row_u"], row["row_v"] = slot.transform[:3], slot.transform[3:]
    return rows


def decoded_bytes() -> np.ndarray:
    """What each byte of a texture stands for, shape (512,): where it is linear, then sRGB (IEC 61966-2-1)."""
    encoded = np.arange(256) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return np.concatenate([encoded, linear]).astype(np.float32)

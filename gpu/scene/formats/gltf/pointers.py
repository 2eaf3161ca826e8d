"""What an animation's JSON pointer is of (KHR_animation_pointer): a property of a node, a material or a light."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

from gpu.scene.animation.motion import Property
from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.values import Value

_EXTENSION = "KHR_animation_pointer"
_NODES = {
    "translation": Property.TRANSLATION,
    "rotation": Property.ROTATION,
    "scale": Property.SCALE,
    "weights": Property.WEIGHTS,
    "extensions/KHR_node_visibility/visible": Property.VISIBLE,
}
_MATERIALS = {
    "pbrMetallicRoughness/baseColorFactor": Property.BASE_COLOR,
    "pbrMetallicRoughness/metallicFactor": Property.METALLIC,
    "pbrMetallicRoughness/roughnessFactor": Property.ROUGHNESS,
    "emissiveFactor": Property.EMISSIVE,
    "extensions/KHR_materials_emissive_strength/emissiveStrength": Property.EMISSIVE_STRENGTH,
    "alphaCutoff": Property.ALPHA_CUTOFF,
    "normalTexture/scale": Property.NORMAL_SCALE,
    "extensions/KHR_materials_transmission/transmissionFactor": Property.TRANSMISSION,
    "extensions/KHR_materials_ior/ior": Property.IOR,
    "extensions/KHR_materials_dispersion/dispersion": Property.DISPERSION,
    "extensions/KHR_materials_volume/attenuationColor": Property.ATTENUATION_COLOR,
    "extensions/KHR_materials_specular/specularFactor": Property.SPECULAR,
    "extensions/KHR_materials_specular/specularColorFactor": Property.SPECULAR_COLOR,
    "extensions/KHR_materials_clearcoat/clearcoatFactor": Property.CLEARCOAT,
    "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor": Property.CLEARCOAT_ROUGHNESS,
    "extensions/KHR_materials_sheen/sheenColorFactor": Property.SHEEN_COLOR,
    "extensions/KHR_materials_sheen/sheenRoughnessFactor": Property.SHEEN_ROUGHNESS,
    "extensions/KHR_materials_iridescence/iridescenceFactor": Property.IRIDESCENCE,
    "extensions/KHR_materials_iridescence/iridescenceIor": Property.IRIDESCENCE_IOR,
    "extensions/KHR_materials_iridescence/iridescenceThicknessMinimum": Property.IRIDESCENCE_LEAST,
    "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum": Property.IRIDESCENCE_MOST,
    "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor": Property.THROUGH,
    "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor": Property.THROUGH_COLOR,
}
_LIGHTS = {
    "color": Property.LIGHT_COLOR,
    "intensity": Property.INTENSITY,
    "spot/innerConeAngle": Property.INNER_CONE,
    "spot/outerConeAngle": Property.OUTER_CONE,
}
_LIGHT_ARRAY = "extensions/KHR_lights_punctual/lights"
_KNOWN: Mapping[str, Mapping[str, Property]] = {"nodes": _NODES, "materials": _MATERIALS, _LIGHT_ARRAY: _LIGHTS}
_POINTER = re.compile(rf"/(nodes|materials|{_LIGHT_ARRAY})/(0|[1-9][0-9]{{0,8}})/(.+)")
# Of a product, and of a cone, one is nothing without the other: that one, and its default.
_OTHER = {
    Property.EMISSIVE: (Property.EMISSIVE_STRENGTH, (1.0,)),
    Property.EMISSIVE_STRENGTH: (Property.EMISSIVE, (0.0, 0.0, 0.0)),
    Property.LIGHT_COLOR: (Property.INTENSITY, (1.0,)),
    Property.INTENSITY: (Property.LIGHT_COLOR, (1.0, 1.0, 1.0)),
    Property.INNER_CONE: (Property.OUTER_CONE, (pi / 4.0,)),
    Property.OUTER_CONE: (Property.INNER_CONE, (0.0,)),
}


@dataclass(frozen=True)
class Pointed:
    """A property of the object of that number in the file's `array`."""

    array: str
    number: int
    changes: Property

    @property
    def of_light(self) -> bool:
        """Whether the object is a light."""
        return self.array == _LIGHT_ARRAY


def pointed(document: Document, target: Value) -> Pointed:
    """What the pointer of a channel's `target` is of. Raises SceneError for what is not there or does not move."""
    place = target.object("extensions").object(_EXTENSION).get("pointer")
    pointer = place.as_text()
    found = _POINTER.fullmatch(pointer)
    if found is None:
        raise place.error(f"must lead to a property of a node, a material or a light, not {pointer!r:.120}")
    array, number, rest = found[1], int(found[2]), found[3]
    if number >= len(_entries(document, array)):
        raise place.error(f"{pointer!r:.120} leads to what does not exist")
    if rest not in _KNOWN[array]:
        what = "texture transforms do not move" if "KHR_texture_transform" in rest else "this does not move"
        raise place.error(f"{pointer!r:.120}: {what} here")
    return Pointed(array, number, _KNOWN[array][rest])


def other_factor(document: Document, changes: Property, number: int) -> tuple[Property, tuple[float, ...]] | None:
    """The property without which one that `changes` means nothing, and what the file says of it for the material or
    light of that number; None where there is none.
    """
    if changes not in _OTHER:
        return None
    other, default = _OTHER[changes]
    array, path = next((array, path) for array in _KNOWN for path, one in _KNOWN[array].items() if one is other)
    *above, key = path.split("/")
    place = _entries(document, array)[number]
    for name in above:
        place = place.part(name)
    if len(default) == 1:
        return other, (place.factor(key, default[0]),)
    return other, place.factors(key, default)


def shining_materials(document: Document) -> frozenset[int]:
    """Numbers of the materials whose emission changes with time."""
    found = set[int]()
    for animation in document.root.parts("animations"):
        for channel in animation.parts("channels") if isinstance(animation.raw, dict) else ():
            pointer = channel.part("target").named_extension(_EXTENSION) if isinstance(channel.raw, dict) else channel
            match = _POINTER.fullmatch(str(pointer.raw.get("pointer", ""))) if isinstance(pointer.raw, dict) else None
            if match and _MATERIALS.get(match[3]) in (Property.EMISSIVE, Property.EMISSIVE_STRENGTH):
                found.add(int(match[2]))
    return frozenset(found)


def _entries(document: Document, array: str) -> list[Value]:
    *above, key = array.split("/")
    place = document.root
    for name in above:
        place = place.part(name)
    return place.parts(key)

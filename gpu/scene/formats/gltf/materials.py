"""Materials of a glTF file: metallic-roughness with the extensions that light transport uses."""

from math import cos, inf, sin

import numpy as np

from gpu.scene.colors import mean_color
from gpu.scene.formats.gltf.images import Images
from gpu.scene.formats.gltf.pointers import shining_materials
from gpu.scene.formats.gltf.specular_glossiness import converted
from gpu.scene.formats.gltf.values import Value
from gpu.scene.types import AlphaMode, Material, Rgb, TextureSlot

_ALPHA_MODES = {"OPAQUE": AlphaMode.OPAQUE, "MASK": AlphaMode.MASK, "BLEND": AlphaMode.BLEND}
_MOST = 1e30  # radiance: so that float32 holds what is computed with it
_LARGE = 1e6
_INFINITE_IOR = 1e6  # what an index of 0 stands for: everything is reflected
_EXTENSIONS = ("transmission", "volume", "specular", "emissive_strength", "ior", "clearcoat", "sheen", "iridescence",
               "anisotropy", "diffuse_transmission", "dispersion")  # fmt: skip
_GLOSSY = "KHR_materials_pbrSpecularGlossiness"
_WHITE, _BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)

DEFAULT_MATERIAL = Material(name="glTF default", metallic=1.0, double_sided=False)
"""What a primitive without a material has (glTF 2.0, section 3.9.6)."""


def read_materials(images: Images) -> list[Material]:
    """All materials of the file, in its order; what is broken in one is mended or left out. Raises ForbiddenError."""
    entries = images.buffers.document.root.parts("materials")
    shining = shining_materials(images.buffers.document)
    return [_material(images, entry, number, number in shining) for number, entry in enumerate(entries)]


def _material(images: Images, entry: Value, number: int, shines: bool) -> Material:
    """shines: at some time, whatever its emission is now."""
    glossy = entry.part("extensions").has(_GLOSSY)
    base = entry.part("pbrMetallicRoughness") if not glossy else Value(entry.source, entry.path, {})
    transmission, volume, specular, strength, ior, coat, sheen, film, grain, through, dispersion = (
        entry.named_extension(f"KHR_materials_{name}") for name in _EXTENSIONS
    )
    _say_unused(images, entry, volume)
    emission = entry.factors("emissiveFactor", _BLACK, 0.0, _MOST)
    if max(emission) > 1.0:
        entry.get("emissiveFactor").mend("is above 1, which glTF leaves to the emissive strength; it was used as it is")
    normal, coat_normal = entry.part("normalTexture"), coat.part("clearcoatNormalTexture")
    material = Material(
        name=entry.name(f"material {number}"),
        base_color=_rgba(base.factors("baseColorFactor", (1.0, 1.0, 1.0, 1.0), 0.0, 1.0)),
        metallic=base.factor("metallicFactor", 1.0, 0.0, 1.0),
        roughness=base.factor("roughnessFactor", 1.0, 0.0, 1.0),
        emission=_rgb(emission, strength.factor("emissiveStrength", 1.0, 0.0, _MOST)),
        base_color_slot=_slot(images, base, "baseColorTexture", srgb=True),
        metallic_roughness_slot=_slot(images, base, "metallicRoughnessTexture"),
        normal_slot=_slot(images, entry, "normalTexture"),
        emission_slot=_slot(images, entry, "emissiveTexture", srgb=True) if any(emission) or shines else None,
        transmission_slot=_slot(images, transmission, "transmissionTexture"),
        normal_scale=normal.factor("scale", 1.0, -_LARGE, _LARGE),
        alpha_mode=entry.choice("alphaMode", _ALPHA_MODES, AlphaMode.OPAQUE),
        alpha_cutoff=entry.factor("alphaCutoff", 0.5, 0.0),
        double_sided=entry.flag("doubleSided"),
        unlit=entry.part("extensions").has("KHR_materials_unlit"),
        transmission=transmission.factor("transmissionFactor", 0.0, 0.0, 1.0),
        ior=_ior(ior),
        dispersion=dispersion.factor("dispersion", 0.0, 0.0, _LARGE),
        thickness=volume.factor("thicknessFactor", 0.0, 0.0, _MOST),
        attenuation_color=_rgb(volume.factors("attenuationColor", _WHITE, 0.0, 1.0)),
        attenuation_distance=_attenuation_distance(volume),
        specular=specular.factor("specularFactor", 1.0, 0.0, 1.0),
        specular_color=_rgb(specular.factors("specularColorFactor", _WHITE, 0.0, _MOST)),
        specular_slot=_slot(images, specular, "specularTexture"),
        specular_color_slot=_slot(images, specular, "specularColorTexture", srgb=True),
        clearcoat=coat.factor("clearcoatFactor", 0.0, 0.0, 1.0),
        clearcoat_roughness=coat.factor("clearcoatRoughnessFactor", 0.0, 0.0, 1.0),
        clearcoat_slot=_slot(images, coat, "clearcoatTexture"),
        clearcoat_roughness_slot=_slot(images, coat, "clearcoatRoughnessTexture"),
        stays_light=shines,
        clearcoat_normal_slot=_slot(images, coat, "clearcoatNormalTexture"),
        clearcoat_normal_scale=coat_normal.factor("scale", 1.0, -_LARGE, _LARGE),
        sheen_color=_rgb(sheen.factors("sheenColorFactor", _BLACK, 0.0, 1.0)),
        sheen_roughness=sheen.factor("sheenRoughnessFactor", 0.0, 0.0, 1.0),
        sheen_color_slot=_slot(images, sheen, "sheenColorTexture", srgb=True),
        sheen_roughness_slot=_slot(images, sheen, "sheenRoughnessTexture"),
        iridescence=film.factor("iridescenceFactor", 0.0, 0.0, 1.0),
        iridescence_ior=film.factor("iridescenceIor", 1.3, 1.0, _LARGE),
        iridescence_least=film.factor("iridescenceThicknessMinimum", 100.0, 0.0, _LARGE),
        iridescence_most=film.factor("iridescenceThicknessMaximum", 400.0, 0.0, _LARGE),
        iridescence_slot=_slot(images, film, "iridescenceTexture"),
        iridescence_thickness_slot=_slot(images, film, "iridescenceThicknessTexture"),
        anisotropy=grain.factor("anisotropyStrength", 0.0, 0.0, 1.0),
        anisotropy_rotation=grain.factor("anisotropyRotation", 0.0, -_LARGE, _LARGE),
        anisotropy_slot=_slot(images, grain, "anisotropyTexture"),
        diffuse_transmission=through.factor("diffuseTransmissionFactor", 0.0, 0.0, 1.0),
        diffuse_transmission_color=_rgb(through.factors("diffuseTransmissionColorFactor", _WHITE, 0.0, 1.0)),
        diffuse_transmission_slot=_slot(images, through, "diffuseTransmissionTexture"),
        diffuse_transmission_color_slot=_slot(images, through, "diffuseTransmissionColorTexture", srgb=True),
    )
    if material.transmission > 0.0 and not (material.is_clear or material.is_part_glass):
        problem = (
            "lets light through as frosted glass does (KHR_materials_transmission), all of which --method path shows"
        )
        images.buffers.document.notes.add(problem, entry.name(entry.path))
    if material.is_translucent and material.absorbs:
        problem = "absorbs light that is scattered into it (KHR_materials_volume), which --method path alone shows"
        images.buffers.document.notes.add(problem, entry.name(entry.path))
    return _from_glossy(images, entry, material) if glossy else material


def _from_glossy(images: Images, entry: Value, material: Material) -> Material:
    """`material` with what KHR_materials_pbrSpecularGlossiness says of it; of its gloss texture the mean counts."""
    place = entry.named_extension(_GLOSSY)
    diffuse = np.array(place.factors("diffuseFactor", (1.0, 1.0, 1.0, 1.0), 0.0, 1.0))
    gloss = np.array(
        [*place.factors("specularFactor", _WHITE, 0.0, 1.0), place.factor("glossinessFactor", 1.0, 0.0, 1.0)]
    )
    slot, glossy = (_slot(images, place, key, srgb=True) for key in ("diffuseTexture", "specularGlossinessTexture"))
    if glossy is not None:
        gloss *= mean_color(images.textures[glossy.texture])
    texture = None if slot is None else (slot, mean_color(images.textures[slot.texture]))
    problem = f"was converted from specular and glossiness ({_GLOSSY}), as near as metallic-roughness can be"
    images.buffers.document.notes.add(problem, material.name)
    return converted(material, diffuse, gloss[:3], float(gloss[3]), texture)


def _slot(images: Images, place: Value, key: str, srgb: bool = False) -> TextureSlot | None:
    """The texture that `place` uses at `key`, with KHR_texture_transform; None where there is none that can be read."""
    if not place.has(key):
        return None
    return images.buffers.document.attempt(lambda: _read_slot(images, place.object(key), srgb), "the texture")


def _read_slot(images: Images, info: Value, srgb: bool) -> TextureSlot | None:
    change = info.named_extension("KHR_texture_transform")
    limit = images.buffers.document.limits.max_uv_sets - 1
    uv_set = change.integer("texCoord", info.integer("texCoord", 0, 0, limit), 0, limit)
    texture = images.texture(info, srgb)
    if texture is None:
        return None
    u, v = change.factors("offset", (0.0, 0.0), -_LARGE, _LARGE)
    su, sv = change.factors("scale", (1.0, 1.0), -_LARGE, _LARGE)
    angle = change.factor("rotation", 0.0, -_LARGE, _LARGE)
    # Counter-clockwise as seen with v pointing down, which is what the extension's examples mean.
    return TextureSlot(texture, uv_set, (cos(angle) * su, sin(angle) * sv, u, -sin(angle) * su, cos(angle) * sv, v))


def _say_unused(images: Images, entry: Value, volume: Value) -> None:
    say = images.buffers.document.ignored.add
    if entry.has("occlusionTexture"):
        say("occlusion textures were ignored: the light itself is computed")
    if volume.has("thicknessTexture"):
        say("textures of thickness are not supported and were ignored; its factor counts")


def _ior(extension: Value) -> float:
    if extension.raw.get("ior") == 0:
        return _INFINITE_IOR
    return extension.factor("ior", 1.5, 1.0, _INFINITE_IOR)


def _attenuation_distance(volume: Value) -> float:
    distance = volume.factor("attenuationDistance", inf, 0.0)
    if distance == 0.0:
        volume.get("attenuationDistance").mend("must be greater than 0; infinity was used")
        return inf
    return distance


def _rgb(values: tuple[float, ...], factor: float = 1.0) -> Rgb:
    return (values[0] * factor, values[1] * factor, values[2] * factor)


def _rgba(values: tuple[float, ...]) -> tuple[float, float, float, float]:
    return (values[0], values[1], values[2], values[3])

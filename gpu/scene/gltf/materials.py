"""Materials of a glTF file: metallic-roughness with the extensions that light transport uses."""

from math import cos, inf, sin

from gpu.scene.gltf.images import Images
from gpu.scene.gltf.values import Value
from gpu.scene.types import AlphaMode, Material, Rgb, TextureSlot

_ALPHA_MODES = {"OPAQUE": AlphaMode.OPAQUE, "MASK": AlphaMode.MASK, "BLEND": AlphaMode.BLEND}
_INFINITE_IOR = 1e6  # what an index of 0 stands for: everything is reflected
_WHITE, _BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)

DEFAULT_MATERIAL = Material(name="glTF default", metallic=1.0)
"""What a primitive without a material has (glTF 2.0, section 3.9.6)."""


def read_materials(images: Images) -> list[Material]:
    """All materials of the file, in its order. Raises SceneError when one is broken."""
    entries = images.buffers.document.root.objects("materials")
    return [_material(images, entry, number) for number, entry in enumerate(entries)]


def _material(images: Images, entry: Value, number: int) -> Material:
    base = entry.object("pbrMetallicRoughness")
    transmission, volume, specular, strength, ior = (
        entry.extension(f"KHR_materials_{name}") or Value(entry.source, entry.path, {})
        for name in ("transmission", "volume", "specular", "emissive_strength", "ior")
    )
    _say_unused(images, entry, volume, specular)
    emission = entry.numbers("emissiveFactor", _BLACK, 0.0, 1.0)
    normal = entry.object("normalTexture")
    return Material(
        name=entry.text("name", f"material {number}"),
        base_color=_rgba(base.numbers("baseColorFactor", (1.0, 1.0, 1.0, 1.0), 0.0, 1.0)),
        metallic=base.number("metallicFactor", 1.0, 0.0, 1.0),
        roughness=base.number("roughnessFactor", 1.0, 0.0, 1.0),
        emission=_rgb(emission, strength.number("emissiveStrength", 1.0, 0.0)),
        base_color_slot=_slot(images, base, "baseColorTexture", srgb=True),
        metallic_roughness_slot=_slot(images, base, "metallicRoughnessTexture"),
        normal_slot=_slot(images, entry, "normalTexture"),
        emission_slot=_slot(images, entry, "emissiveTexture", srgb=True) if any(emission) else None,
        transmission_slot=_slot(images, transmission, "transmissionTexture"),
        normal_scale=normal.number("scale", 1.0),
        alpha_mode=_alpha_mode(entry),
        alpha_cutoff=entry.number("alphaCutoff", 0.5, 0.0),
        double_sided=entry.flag("doubleSided"),
        unlit=entry.extension("KHR_materials_unlit") is not None,
        transmission=transmission.number("transmissionFactor", 0.0, 0.0, 1.0),
        ior=_ior(ior),
        thickness=volume.number("thicknessFactor", 0.0, 0.0),
        attenuation_color=_rgb(volume.numbers("attenuationColor", _WHITE, 0.0, 1.0)),
        attenuation_distance=_attenuation_distance(volume),
        specular=specular.number("specularFactor", 1.0, 0.0, 1.0),
        specular_color=_rgb(specular.numbers("specularColorFactor", _WHITE, 0.0)),
    )


def _slot(images: Images, place: Value, key: str, srgb: bool = False) -> TextureSlot | None:
    """The texture that `place` uses at `key`, with KHR_texture_transform, or None."""
    if not place.has(key):
        return None
    info = place.object(key)
    texture = images.texture(info, srgb)
    if texture is None:
        return None
    change = info.extension("KHR_texture_transform") or Value(info.source, info.path, {})
    limit = images.buffers.document.limits.max_uv_sets - 1
    uv_set = change.integer("texCoord", info.integer("texCoord", 0, 0, limit), 0, limit)
    u, v = change.numbers("offset", (0.0, 0.0))
    su, sv = change.numbers("scale", (1.0, 1.0))
    angle = change.number("rotation", 0.0)
    # Counter-clockwise as seen with v pointing down, which is what the extension's examples mean.
    return TextureSlot(texture, uv_set, (cos(angle) * su, sin(angle) * sv, u, -sin(angle) * su, cos(angle) * sv, v))


def _say_unused(images: Images, entry: Value, volume: Value, specular: Value) -> None:
    say = images.buffers.document.say
    if entry.has("occlusionTexture"):
        say("occlusion textures were ignored: the light itself is computed")
    for place, key in ((volume, "thicknessTexture"), (specular, "specularTexture"), (specular, "specularColorTexture")):
        if place.has(key):
            say(f"textures of {key.removesuffix('Texture')} are not supported and were ignored; its factor counts")


def _alpha_mode(entry: Value) -> AlphaMode:
    mode = entry.text("alphaMode", "OPAQUE")
    if mode not in _ALPHA_MODES:
        raise entry.get("alphaMode").error(f"must be one of {', '.join(_ALPHA_MODES)}, not {mode!r:.40}")
    return _ALPHA_MODES[mode]


def _ior(extension: Value) -> float:
    ior = extension.number("ior", 1.5, 0.0) or _INFINITE_IOR
    if ior < 1.0:
        raise extension.get("ior").error(f"must be 0 or at least 1, not {ior:g}")
    return ior


def _attenuation_distance(volume: Value) -> float:
    distance = volume.number("attenuationDistance", inf, 0.0)
    if distance == 0.0:
        raise volume.get("attenuationDistance").error("must be greater than 0")
    return distance


def _rgb(values: tuple[float, ...], factor: float = 1.0) -> Rgb:
    return (values[0] * factor, values[1] * factor, values[2] * factor)


def _rgba(values: tuple[float, ...]) -> tuple[float, float, float, float]:
    return (values[0], values[1], values[2], values[3])

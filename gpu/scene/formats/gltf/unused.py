"""What a glTF file says that nothing here uses: its JSON beside a table of what is known of each kind of object."""

import re
from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import Any

from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.extensions import SUPPORTED, used_extensions
from gpu.scene.formats.gltf.hierarchy import PlacedNode
from gpu.scene.types import Material
from gpu.scene.validate import slots

_LISTED = 8  # names that a sentence lists
_ATTRIBUTES = "meshes[].primitives[].attributes"
_TARGETS = "meshes[].primitives[].targets[]"
_TEXTURE = {"index", "texCoord"}
# The keys of an object by its kind: those that are read or said elsewhere, and those that only describe. What is in an
# object of no kind here is not looked at: its reader knows it all.
_KNOWN: dict[str, set[str]] = {
    "": {
        *("asset", "scene", "scenes", "nodes", "meshes", "materials", "textures", "images", "samplers", "cameras"),
        *("skins", "accessors", "bufferViews", "buffers", "extensionsUsed", "extensionsRequired", "animations"),
    },
    "asset": {"version", "minVersion", "generator", "copyright"},
    "scenes[]": {"name", "nodes"},
    "nodes[]": {
        *("name", "children", "matrix", "translation", "rotation", "scale", "mesh", "camera", "skin", "weights"),
    },
    "meshes[]": {"name", "primitives", "weights"},
    "meshes[].primitives[]": {"attributes", "indices", "material", "mode", "targets"},
    _TARGETS: {"POSITION", "NORMAL"},
    "materials[]": {
        *("name", "pbrMetallicRoughness", "normalTexture", "occlusionTexture", "emissiveTexture", "emissiveFactor"),
        *("alphaMode", "alphaCutoff", "doubleSided"),
    },
    "materials[].pbrMetallicRoughness": {
        *("baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor", "metallicRoughnessTexture"),
    },
    "materials[].pbrMetallicRoughness.baseColorTexture": _TEXTURE,
    "materials[].pbrMetallicRoughness.metallicRoughnessTexture": _TEXTURE,
    "materials[].normalTexture": {*_TEXTURE, "scale"},
    "materials[].emissiveTexture": _TEXTURE,
    "textures[]": {"name", "source", "sampler"},
    "images[]": {"name", "uri", "mimeType", "bufferView"},
    "samplers[]": {"name", "magFilter", "minFilter", "wrapS", "wrapT"},
    "cameras[]": {"name", "type", "perspective", "orthographic"},
    "cameras[].perspective": {"yfov", "aspectRatio", "znear", "zfar"},
    "cameras[].orthographic": {"xmag", "ymag", "znear", "zfar"},
    "animations[]": {"name", "channels", "samplers"},
    "animations[].channels[]": {"sampler", "target"},
    "animations[].channels[].target": {"node", "path"},
    "animations[].samplers[]": {"input", "output", "interpolation"},
    "skins[]": {"name", "joints", "inverseBindMatrices", "skeleton"},
    "accessors[]": {
        *("name", "bufferView", "byteOffset", "componentType", "normalized", "count", "type", "min", "max", "sparse"),
    },
    "bufferViews[]": {"name", "buffer", "byteOffset", "byteLength", "byteStride", "target"},
    "buffers[]": {"name", "uri", "byteLength"},
    "extensions.KHR_lights_punctual": {"lights"},
    "extensions.KHR_lights_punctual.lights[]": {"name", "type", "color", "intensity", "range", "spot"},
}
# The keys of an object by its kind that lead to objects of other kinds.
_LEADING = {
    kind: {key for key in known if {path := f"{kind}.{key}".lstrip("."), f"{path}[]"} & {*_KNOWN, _ATTRIBUTES}}
    for kind, known in _KNOWN.items()
}


# What a picture lacks without an extension, where its name alone would not tell.
_LEFT_OUT = {
    "EXT_lights_image_based": ": the light around the scene is left out; --environment takes a picture of one",
}


@dataclass
class _Found:
    """How often a key that is not known, and an extension of a kind of object, is in the file; keys of extras."""

    keys: Counter[str] = field(default_factory=Counter)
    extensions: dict[str, Counter[str]] = field(default_factory=dict)
    extras: dict[str, None] = field(default_factory=dict)


def say_unused(document: Document, nodes: Iterable[PlacedNode], materials: Collection[Material]) -> None:
    """Say what the file has but the scene of `nodes` does not show, a sentence for each key, extension and extras."""
    found = _Found()
    _walk(document.root.raw, "", found)
    for path, count in found.keys.items():
        if not _is_used(path, materials):
            document.ignored.add_count(f"{path} is not used", count)
    for name in dict.fromkeys([*used_extensions(document), *found.extensions]):
        if name not in SUPPORTED:
            lost = _LEFT_OUT.get(name, "")
            document.ignored.add(f"extension {name} is not supported and was ignored{lost}{_where(found, name)}")
    if found.extras:
        listed, more = list(found.extras)[:_LISTED], len(found.extras) - _LISTED
        document.notes.add(f"extras are not used: {', '.join(listed)}{f' and {more} more' if more > 0 else ''}")
    _say_unplaced(document, [node.entry.raw for node in nodes])


def _walk(value: Any, kind: str, found: _Found) -> None:
    if isinstance(value, list):
        kind = f"{kind}[]"
        for item in value:
            _walk(item, kind, found)
    elif isinstance(value, dict) and kind == _ATTRIBUTES:
        found.keys.update(f"{kind}.{name:.40}" for name in value)
    elif isinstance(value, dict) and kind in _KNOWN:
        known = _KNOWN[kind]
        if value.keys() <= known:  # as most of a large file is
            for key in [key for key in value if key in _LEADING[kind]] if _LEADING[kind] else ():
                _walk(value[key], f"{kind}.{key}" if kind else key, found)
            return
        for key, inner in value.items():
            path = f"{kind}.{key:.40}" if kind else f"{key:.40}"
            if key == "extras":
                found.extras.update(dict.fromkeys(f"{name:.40}" for name in inner) if isinstance(inner, dict) else {})
            elif key == "extensions":
                for name in inner if isinstance(inner, dict) else ():
                    found.extensions.setdefault(name, Counter())[kind] += 1
                    _walk(inner[name], f"{path}.{name}", found)
            elif key in known:
                _walk(inner, path, found)
            else:
                found.keys[path] += 1


def _is_used(path: str, materials: Collection[Material]) -> bool:
    """Whether an attribute or a key that is in no table says something of the surfaces with these materials."""
    owner, _, name = path.rpartition(".")
    if name == "TANGENT":
        return all(material.normal_slot is None or material.has_grain for material in materials)
    if owner != _ATTRIBUTES:
        return False
    uv_sets = {slot.uv_set for material in materials for slot in slots(material).values()}
    listed = {"POSITION", "NORMAL", "COLOR_0", "TEXCOORD_0", *(f"TEXCOORD_{uv_set}" for uv_set in uv_sets)}
    return name in listed or re.fullmatch(r"(JOINTS|WEIGHTS)_\d+", name) is not None


def _where(found: _Found, name: str) -> str:
    """Of how many objects of which kind an extension is: " (3 materials)"."""
    places = found.extensions.get(name, Counter[str]())
    counts = [f"{count} {kind.replace('[]', '').rpartition('.')[2]}" for kind, count in places.items() if kind]
    return f" ({', '.join(counts)})" if counts else ""


def _say_unplaced(document: Document, placed: list[dict[str, Any]]) -> None:
    """Say how many nodes, meshes and cameras no node of the file's only scene leads to."""
    root = document.root
    if len(root.parts("scenes")) > 1:
        return  # which is said already
    counts = {"nodes": len(root.parts("nodes")) - len(placed)}
    for key, array in (("mesh", "meshes"), ("camera", "cameras")):
        named = {entry[key] for entry in placed if isinstance(entry.get(key), int | float)}
        counts[array] = len(root.parts(array)) - len(named & {*range(len(root.parts(array)))})
    missing = ", ".join(f"{count} {array}" for array, count in counts.items() if count > 0)
    if missing:
        document.ignored.add(f"what is in no scene is not shown: {missing}")

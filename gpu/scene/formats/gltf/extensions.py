"""Which glTF extensions are read, and which of the others a file can be shown without though it requires them."""

from gpu.scene.formats.extras import library
from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.values import Value

SUPPORTED = frozenset(
    {
        "EXT_mesh_gpu_instancing",
        "EXT_meshopt_compression",
        "EXT_texture_webp",
        "KHR_animation_pointer",
        "KHR_draco_mesh_compression",
        "KHR_lights_punctual",
        "KHR_materials_anisotropy",
        "KHR_materials_clearcoat",
        "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_iridescence",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_sheen",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_materials_volume",
        "KHR_materials_variants",
        "KHR_mesh_quantization",
        "KHR_meshopt_compression",
        "KHR_node_visibility",
        "KHR_texture_basisu",
        "KHR_texture_transform",
    }
)

_LIBRARIES = {
    "EXT_meshopt_compression": ("meshopt", "meshopt"),
    "KHR_meshopt_compression": ("meshopt", "meshopt"),
    "KHR_texture_basisu": ("opengl_basisu", "ktx2"),
}
"""The module that reads what an extension packs, and the extra that installs it."""


# These only describe a file.
_DISPENSABLE = frozenset({"KHR_xmp", "KHR_xmp_json_ld"})


def check_extensions(document: Document) -> None:
    """Raise SceneError naming the required extensions that are not supported and cannot be done without.

    One that needs an extra that is not installed is refused by the name of that.
    """
    required = set(_names(document.root, "extensionsRequired"))
    missing = sorted(required - SUPPORTED - _DISPENSABLE)
    if missing:
        raise document.root.get("extensionsRequired").error(
            f"needs {', '.join(missing)}, which is not supported; export the scene without it"
        )
    for name in sorted(required & _LIBRARIES.keys()):
        library(document.root.source, *_LIBRARIES[name])


def used_extensions(document: Document) -> list[str]:
    """The names of the extensions that the file says it uses or needs, sorted."""
    return sorted({name for key in ("extensionsUsed", "extensionsRequired") for name in _names(document.root, key)})


def _names(root: Value, key: str) -> list[str]:
    return [name for item in root.parts(key) if (name := item.mended(item.as_text, "", "it was left out"))]

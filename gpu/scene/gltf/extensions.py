"""Which glTF extensions are read; the others are refused when required, and said when merely used."""

from gpu.scene.gltf.document import Document
from gpu.scene.gltf.values import Value

SUPPORTED = frozenset(
    {
        "EXT_mesh_gpu_instancing",
        "EXT_texture_webp",
        "KHR_draco_mesh_compression",
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_materials_volume",
        "KHR_mesh_quantization",
        "KHR_texture_transform",
    }
)


def check_extensions(document: Document) -> None:
    """Raise SceneError naming the required extensions that are not supported; say which used ones are ignored."""
    required, used = (_names(document.root, key) for key in ("extensionsRequired", "extensionsUsed"))
    missing = sorted(set(required) - SUPPORTED)
    if missing:
        raise document.root.get("extensionsRequired").error(
            f"needs {', '.join(missing)}, which is not supported; export the scene without it"
        )
    for name in sorted(set(used) - SUPPORTED):
        document.ignored.add(f"extension {name} is not supported and was ignored")


def _names(root: Value, key: str) -> list[str]:
    return [name for item in root.parts(key) if (name := item.mended(item.as_text, "", "it was left out"))]

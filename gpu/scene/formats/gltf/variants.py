"""KHR_materials_variants: other materials of the same primitives, of which a user chooses."""

from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.values import Value

_NAME = "KHR_materials_variants"


def variant_names(document: Document) -> list[str]:
    """The file's variants, in its order."""
    entries = document.root.named_extension(_NAME).parts("variants")
    return [entry.name(f"variant {number}") for number, entry in enumerate(entries)]


def chosen_variant(document: Document, wanted: str | None) -> int | None:
    """The number of the variant called `wanted`; None where there is none, which `assemble` refuses."""
    names = variant_names(document)
    return names.index(wanted) if wanted in names else None


def with_material(primitive: Value, variant: int | None) -> Value:
    """Where the material of `primitive` stands in that variant: in a mapping of it, else in itself."""
    if variant is not None:
        for mapping in primitive.named_extension(_NAME).parts("mappings"):
            if any(item.raw == variant for item in mapping.parts("variants")):
                return mapping
    return primitive

"""What a scene says of materials whose blending leaves nothing to see in other methods than path tracing."""

from collections.abc import Iterable

from gpu.scene.remarks import Remarks
from gpu.scene.types import AlphaMode, Material


def blending_notes(materials: Iterable[Material]) -> tuple[str, ...]:
    """A sentence on `materials` that are see-through all over by more than half, as programs without transmission
    write window panes; textures and colours of vertices take more away only.
    """
    notes = Remarks()
    for material in materials:
        if material.alpha_mode is AlphaMode.BLEND and material.base_color[3] < material.solid_alpha:
            notes.add("is more than half see-through (alpha): --method path shows it, others show nothing there",
                      material.name)  # fmt: skip
    return notes.sentences()

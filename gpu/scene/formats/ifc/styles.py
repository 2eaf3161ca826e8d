"""Surface styles of IFC products as materials (IfcPresentationAppearanceResource)."""

from typing import Any

import numpy as np

from gpu.scene.colors import srgb_to_linear
from gpu.scene.formats.mtl import phong_roughness
from gpu.scene.types import AlphaMode, Material, Rgb

_METALS = {"METAL", "MIRROR"}


class Styles:
    """The materials of the styles that were met so far, each once."""

    def __init__(self, model: Any) -> None:
        self.materials: list[Material] = []
        self._model = model
        self._numbers: dict[tuple[int, str], int] = {}

    def number(self, style: Any) -> int:
        """The index in `materials` of what IfcOpenShell calls a style: a surface style, or the colour of a type."""
        key = (style.instance_id(), style.name)
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(self._material(style))
        return self._numbers[key]

    def _material(self, style: Any) -> Material:
        """Matt, unless the style speaks of a highlight; colours of styles are as on a display."""
        entity = self._model.by_id(style.instance_id()) if style.instance_id() > 0 else None
        rendering, ior = None, 1.5
        if entity is not None and entity.is_a("IfcSurfaceStyle"):
            for item in entity.Styles or ():
                if item.is_a("IfcSurfaceStyleRendering"):
                    rendering = item
                elif item.is_a("IfcSurfaceStyleRefraction") and (item.RefractionIndex or 0.0) >= 1.0:
                    ior = float(item.RefractionIndex)
        transparency = _share(style.transparency)
        specular, roughness, metallic = _reflection(rendering)
        return Material(
            name=str((entity.Name if entity is not None else None) or style.name),
            base_color=(*_rgb(style.diffuse), 1.0 - transparency),
            metallic=metallic,
            roughness=roughness,
            specular=specular,
            alpha_mode=AlphaMode.BLEND if transparency > 0.0 else AlphaMode.OPAQUE,
            double_sided=True,
            ior=ior,
        )


def _reflection(rendering: Any | None) -> tuple[float, float, float]:
    """Specular, roughness and metallic of an IfcSurfaceStyleRendering, or of a style without one."""
    if rendering is None:
        return 0.0, 1.0, 0.0
    highlight, method = rendering.SpecularHighlight, rendering.ReflectanceMethod
    metallic = float(method in _METALS)
    if highlight is None:
        return metallic, 0.0 if method == "MIRROR" else 1.0, metallic
    value = max(float(highlight.wrappedValue), 0.0)
    if highlight.is_a("IfcSpecularRoughness"):
        return 1.0, min(value, 1.0), metallic
    return 1.0, phong_roughness(value), metallic


def _share(value: float) -> float:
    """`value` in [0, 1]; 0 where the style has none, which IfcOpenShell tells as not a number."""
    return float(np.clip(np.nan_to_num(value), 0.0, 1.0))


def _rgb(colour: Any) -> Rgb:
    red, green, blue = (
        float(value) for value in srgb_to_linear(np.array([255.0 * _share(level) for level in colour.components]))
    )
    return (red, green, blue)

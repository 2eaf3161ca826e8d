"""KHR_materials_pbrSpecularGlossiness, an older way to describe a surface, as metallic-roughness."""

from dataclasses import replace

import numpy as np

from gpu.scene.types import Doubles, Material, TextureSlot

_DIELECTRIC = 0.04  # what glTF's dielectrics reflect at normal incidence
_METAL = 0.5  # above, a surface is rather a metal: its colour is in what it reflects


def converted(
    material: Material,
    diffuse: Doubles,
    specular: Doubles,
    glossiness: float,
    texture: tuple[TextureSlot, Doubles] | None,
) -> Material:
    """`material` with the metallic-roughness that looks as near as can be to one of these means.

    diffuse: factor (4,), linear red, green, blue and alpha; specular: reflectance (3,) at normal incidence; texture:
    that of the diffuse colour with its mean (4,). As the extension's own example has it, the metallic part is that at
    which a dielectric's diffuse colour and a metal's reflectance are as bright as these two.
    """
    mean = diffuse if texture is None else diffuse * texture[1]
    rest = 1.0 - float(specular.max())
    metallic = _metallic(_brightness(mean[:3]), _brightness(specular), rest)
    kept = texture[0] if texture is not None and metallic <= _METAL else None
    base = (mean if kept is None else diffuse)[:3] * rest / ((1.0 - _DIELECTRIC) * max(1.0 - metallic, 1e-6))
    if kept is None:
        as_metal = (specular - _DIELECTRIC * (1.0 - metallic)) / max(metallic, 1e-6)
        base = base + (as_metal - base) * metallic**2
    red, green, blue = np.clip(base, 0.0, 1.0).tolist()
    color = (red, green, blue, float(diffuse[3]))
    return replace(material, base_color=color, base_color_slot=kept, metallic=metallic, roughness=1.0 - glossiness)


def _brightness(color: Doubles) -> float:
    """Perceived, from 0 to 1: https://alienryderflex.com/hsp.html."""
    return float(np.sqrt(color**2 @ [0.299, 0.587, 0.114]))


def _metallic(diffuse: float, specular: float, rest: float) -> float:
    """The root in [0, 1] of the quadratic equation that both brightnesses give; rest: what specular leaves."""
    if specular <= _DIELECTRIC + 1e-6:
        return 0.0
    b = diffuse * rest / (1.0 - _DIELECTRIC) + specular - 2.0 * _DIELECTRIC
    root = np.sqrt(max(b * b - 4.0 * _DIELECTRIC * (_DIELECTRIC - specular), 0.0))
    return float(np.clip((root - b) / (2.0 * _DIELECTRIC), 0.0, 1.0))

"""Factors of materials and lights that a file has outside their range, where the nearest within it counts instead, and
cameras that can see nothing, which are left out.

What single precision does not hold is outside, too, with room for what is computed with it.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import isnan
from typing import Any

import numpy as np

from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Camera, Light, Material, Rgb, Sky, TextureSlot
from gpu.scene.validate import slots

MOST = 1e30
LARGE = 1e6  # of what is multiplied by such, or by itself
_SHARES = (
    *("base_color", "metallic", "roughness", "transmission", "attenuation_color", "specular"),
    *("clearcoat", "clearcoat_roughness", "sheen_color", "sheen_roughness", "iridescence"),
    *("diffuse_transmission", "diffuse_transmission_color"),
)
_FACTORS = (
    "emission",
    "specular_color",
    "thickness",
    "alpha_cutoff",
    "dispersion",
    "iridescence_least",
    "iridescence_most",
)
# The least and the most of each factor of a material.
_RANGES = {
    **dict.fromkeys(_SHARES, (0.0, 1.0)),
    **dict.fromkeys(_FACTORS, (0.0, MOST)),
    **dict.fromkeys(("ior", "iridescence_ior"), (0.0, LARGE)),
    **dict.fromkeys(("normal_scale", "clearcoat_normal_scale"), (-LARGE, LARGE)),
}
_DEFAULT = Material()


def computable(found: SceneParts) -> SceneParts:
    """What was `found`, with all factors in their range; its notes say what was changed."""
    remarks = Remarks()
    materials = [_material(one, remarks) for one in found.materials]
    lights = [_light(one, remarks) for one in found.lights]
    sky = found.sky
    if isinstance(sky, Sky):
        sky = Sky(_light_of(sky.radiance, "sky.radiance", remarks))
    cameras = [one for one in found.cameras if _sees(one, remarks)]
    meshes = [_part(one, remarks) for one in found.meshes]
    said = remarks.sentences()
    if not said:
        return found
    made = replace(found, meshes=meshes, materials=materials, lights=lights, sky=sky, cameras=cameras)
    return replace(made, notes=(*found.notes, *said))


def _part(part: MeshPart, remarks: Remarks) -> MeshPart:
    """One whose vertex colours are shares; those that are no number stay, which its reader leaves in none."""
    colors = part.colors
    if colors is None or not (colors.min(initial=0.0) < 0.0 or colors.max(initial=1.0) > 1.0):
        return part
    remarks.add("has colours outside 0 to 1, which were clamped", part.name)
    return replace(part, colors=np.clip(colors, 0.0, 1.0).astype(np.float64))


def _material(material: Material, remarks: Remarks) -> Material:
    changed: dict[str, Any] = {}
    for name, (low, high) in _RANGES.items():
        value = getattr(material, name)
        values = value if isinstance(value, tuple) else (value,)
        if not all(low <= one <= high for one in values):
            usual = getattr(_DEFAULT, name)
            usuals = usual if isinstance(usual, tuple) else (usual,)
            made = _within(values, usuals, (low, high), f"{material.name}.{name}", remarks)
            changed[name] = made if isinstance(value, tuple) else made[0]
    for name, slot in slots(material).items():
        if not all(-LARGE <= one <= LARGE for one in slot.transform):
            place = f"{material.name}.{name}.transform"
            made = _within(slot.transform, TextureSlot(0).transform, (-LARGE, LARGE), place, remarks)
            changed[name] = replace(slot, transform=made)  # type: ignore[arg-type]
    return replace(material, **changed) if changed else material


def _light(light: Light, remarks: Remarks) -> Light:
    intensity = _light_of(light.intensity, f"{light.name}.intensity", remarks)
    return light if intensity == light.intensity else replace(light, intensity=intensity)


def _light_of(color: Rgb, place: str, remarks: Remarks) -> Rgb:
    red, green, blue = _within(color, (0.0, 0.0, 0.0), (0.0, MOST), place, remarks)
    return red, green, blue


def _sees(camera: Camera, remarks: Remarks) -> bool:
    """Whether a camera has a field of view that can be computed with, and sees what is nearer than that."""
    sees = np.isfinite(camera.to_world).all() and camera.near <= MOST
    sees = sees and all(0.0 < one <= MOST for one in (camera.half_height, camera.aspect))
    if not sees:
        remarks.add("a camera that cannot see anything was left out", camera.name)
    return bool(sees)


def _within(
    values: Sequence[float], usual: Sequence[float], within: tuple[float, float], place: str, remarks: Remarks
) -> tuple[float, ...]:
    """`values` from the least to the most `within`, and what is `usual` instead of those that are no number."""
    low, high = within
    made = tuple(
        other if isnan(value) else min(max(value, low), high) for value, other in zip(values, usual, strict=True)
    )
    wrong = next(((value, taken) for value, taken in zip(values, made, strict=True) if value != taken), None)
    if wrong is not None:
        problem = f"must be between {low:g} and {high:g}, not {wrong[0]:g}; {wrong[1]:g} was taken"
        remarks.add(problem, place, f"between {low:g} and {high:g}")
    return made

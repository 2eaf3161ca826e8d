"""Numbers that single precision does not hold, or not what is computed with them; the largest that do count instead."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Light, Material

MOST = 1e30
# Of materials; a Fresnel term has the square of an index.
_MOST = {"emission": MOST, "specular_color": MOST, "thickness": MOST, "ior": 1e6, "iridescence_ior": 1e6}


def computable(found: SceneParts) -> SceneParts:
    """What was `found`, with materials and lights that can be computed with; its notes say what was changed."""
    remarks = Remarks()
    materials = [_material(one, f"materials[{number}]", remarks) for number, one in enumerate(found.materials)]
    lights = [_light(one, f"lights[{number}]", remarks) for number, one in enumerate(found.lights)]
    said = remarks.sentences()
    return replace(found, materials=materials, lights=lights, notes=(*found.notes, *said)) if said else found


def _material(material: Material, place: str, remarks: Remarks) -> Material:
    """One whose numbers are not above `_MOST`."""
    changed: dict[str, Any] = {}
    for name, most in _MOST.items():
        value = getattr(material, name)
        largest = max(value) if isinstance(value, tuple) else value
        if largest > most:
            remarks.add(f"is more than can be computed with; {most:g} was taken", f"{place}.{name}")
            changed[name] = _least(value, most) if isinstance(value, tuple) else most
    return replace(material, **changed) if changed else material


def _light(light: Light, place: str, remarks: Remarks) -> Light:
    if max(light.intensity) <= MOST:
        return light
    remarks.add(f"is more than can be computed with; {MOST:g} was taken", f"{place}.intensity")
    red, green, blue = _least(light.intensity, MOST)
    return replace(light, intensity=(red, green, blue))


def _least(values: Sequence[float], most: float) -> tuple[float, ...]:
    return tuple(min(value, most) for value in values)

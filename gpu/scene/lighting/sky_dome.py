"""Finds the sky that many files put around a scene: a dome, a sphere or a box of unlit or emissive triangles.

As solid as other surfaces it would keep sun and sky out, and its size would count as the scene's.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gpu.scene.geometry.boxes import box
from gpu.scene.types import Doubles, Integers, Material

_SHELL = 1.2 * np.pi  # solid angle that a shell takes of the middle of the scene [sr]: less than half of all directions
_PART = 0.4  # of one material of it
_WIDE = 0.5  # of the scene's extent, along two axes: what one material of a shell has at least
_SLACK = 0.05  # of the shell's extent: by so much the scene may stand out of it


def with_sky_dome(positions: Doubles, triangles: Integers, material: Integers, materials: Sequence[Material],
                  *, sun: bool) -> list[Material]:  # fmt: skip
    """`materials`, those whose triangles are a sky around all others as backdrops.

    positions (vertex, 3) in any space, triangles (triangle, 3), material (triangle,). A sky is a shell of materials
    that are unlit or, where there is a sun that it would shut out, emissive.
    """
    shown = np.array([m.unlit or (sun and m.emits) for m in materials])[material]
    if not shown.any() or shown.all():
        return list(materials)
    low, high = box(positions, triangles[~shown])
    shell: list[int] = []
    total = 0.0
    for number in np.unique(material[shown]).tolist():
        own = triangles[material == number]
        angle = abs(float(_solid_angles(positions[own] - (low + high) / 2.0).sum()))
        own_low, own_high = box(positions, own)
        if angle >= _PART and np.count_nonzero(own_high - own_low >= _WIDE * (high - low)) >= 2:
            shell.append(number)
            total += angle
    if total < _SHELL:
        return list(materials)
    outer_low, outer_high = box(positions, triangles[np.isin(material, shell)])
    slack = _SLACK * (outer_high - outer_low)
    if (outer_low - slack > low).any() or (outer_high + slack < high).any():
        return list(materials)
    return [replace(m, backdrop=True) if number in shell else m for number, m in enumerate(materials)]


def sky_notes(materials: Sequence[Material]) -> list[str]:
    """A sentence on the backdrop, if there is one."""
    names = [repr(material.name) for material in materials if material.backdrop]
    if not names:
        return []
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return [f"the sky around the scene, {names[0]}{more}, is shown behind it and stops no light"]


def _solid_angles(corners: Doubles) -> Doubles:
    """Signed solid angles (triangle,) of corners (triangle, 3, 3) about 0 (van Oosterom and Strackee, 1983)."""
    a, b, c = (corners / np.maximum(np.linalg.norm(corners, axis=2, keepdims=True), 1e-300)).transpose(1, 0, 2)
    volume = np.einsum("tk,tk->t", a, np.cross(b, c))
    rest = 1.0 + sum(np.einsum("tk,tk->t", p, q) for p, q in ((a, b), (b, c), (c, a)))
    return np.asarray(2.0 * np.arctan2(volume, rest))

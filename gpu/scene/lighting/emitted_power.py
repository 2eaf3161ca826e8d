"""The power of a scene's emissive surfaces, estimated from points on them."""

import numpy as np

from gpu.scene.geometry.boxes import lengths
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.geometry.texture_samples import sample_texture
from gpu.scene.types import AlphaMode, Doubles, Floats, Integers, Material, Scene, TextureSlot

_POINTS = 1 << 16  # of a material whose emission differs from place to place
_WHITE = np.ones((1, 4))
# Steps of an even sequence in two dimensions (M. Roberts, The Unreasonable Effectiveness of Quasirandom Sequences).
_STEPS = 0.7548776662466927, 0.5698402909980532


def emitted_power(scene: Scene) -> Doubles:
    """Power [W] (material, 3) that the surfaces of each material emit, in world units.

    A Lambertian emitter of radiance L and area A has the power π·A·L on each side that emits. What alpha cuts away
    emits nothing, and of BLEND the share that is there.
    """
    power = np.zeros((len(scene.materials), 3))
    if not any(material.emits for material in scene.materials):
        return power
    areas = lengths(area_vectors(scene.vertices.astype(np.float64), scene.triangles)) / 2.0
    emitting = [(number, material) for number, material in enumerate(scene.materials) if material.emits]
    for number, material in emitting:  # few of what may be many
        own = np.flatnonzero(scene.triangle_material == number)
        if len(own):
            sides = 2.0 if material.double_sided else 1.0
            total = areas[own].sum() / scene.placement.scale**2
            power[number] = sides * np.pi * total * _mean_emission(scene, material, own, areas[own])
    return power


def _mean_emission(scene: Scene, material: Material, triangles: Integers, areas: Doubles) -> Doubles:
    """Radiance (3,) that `material` emits, averaged over `triangles` (triangle,) of these areas."""
    if material.emission_slot is None and material.alpha_mode is AlphaMode.OPAQUE:
        return np.array(material.emission)
    number = np.arange(_POINTS)
    ends = np.cumsum(areas)
    chosen = triangles[np.searchsorted(ends, (number + 0.5) / _POINTS * ends[-1]).clip(0, len(triangles) - 1)]
    root, other = np.sqrt((number * _STEPS[0]) % 1.0), (number * _STEPS[1]) % 1.0
    shares = np.stack([1.0 - root, root * (1.0 - other), root * other], axis=1)
    corners = scene.triangles[chosen]
    emission = np.array(material.emission) * _sampled(scene, material.emission_slot, corners, shares)[:, :3]
    if material.alpha_mode is not AlphaMode.OPAQUE:
        alpha = material.base_color[3] * _sampled(scene, material.base_color_slot, corners, shares)[:, 3]
        if scene.colors is not None:
            alpha = alpha * _interpolated(scene.colors, corners, shares)[:, 3]
        blend = material.alpha_mode is AlphaMode.BLEND
        emission = emission * (alpha if blend else alpha >= material.solid_alpha)[:, None]
    return np.asarray(emission.mean(axis=0))


def _sampled(scene: Scene, slot: TextureSlot | None, corners: Integers, shares: Doubles) -> Doubles:
    """Linear RGBA (point, 4) of a texture at points of triangles; white where there is none."""
    if slot is None:
        return _WHITE
    return sample_texture(scene.textures[slot.texture], slot, _interpolated(scene.uvs[slot.uv_set], corners, shares))


def _interpolated(values: Floats, corners: Integers, shares: Doubles) -> Doubles:
    """Vertices' `values` (vertex, component) at points, by their triangles' corners and barycentrics (point, 3)."""
    return np.einsum("pk,pkc->pc", shares, values[corners].astype(np.float64))

"""Materials and lights at a time of an animation.

Light paths are drawn by the light of the file (gpu.scene.lighting.path_light), so that light that merely changes its
brightness is exact and no path is traced for it.
"""

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import replace
from math import cos, inf, pi
from typing import Any

import numpy as np

from gpu.scene.animation.keyframes import value_at
from gpu.scene.animation.motion import LIGHT_PROPERTIES, MATERIAL_PROPERTIES, Animation, Motion, Property
from gpu.scene.floats import triple
from gpu.scene.lighting.path_light import with_path_light
from gpu.scene.pauses import EVERY, Pause, go_on
from gpu.scene.types import Doubles, Light, LightKind, Material, Scene

MOST = 1e30  # radiance, or W/sr: so that float32 holds what is computed with it
_LARGE = 1e6
Values = Mapping[Property, Doubles]
# The field of a material that a property is, and its range.
_FIELDS = {
    Property.BASE_COLOR: ("base_color", 0.0, 1.0),
    Property.METALLIC: ("metallic", 0.0, 1.0),
    Property.ROUGHNESS: ("roughness", 0.0, 1.0),
    Property.ALPHA_CUTOFF: ("alpha_cutoff", 0.0, inf),
    Property.NORMAL_SCALE: ("normal_scale", -_LARGE, _LARGE),
    Property.TRANSMISSION: ("transmission", 0.0, 1.0),
    Property.IOR: ("ior", 1.0, _LARGE),
    Property.DISPERSION: ("dispersion", 0.0, _LARGE),
    Property.ATTENUATION_COLOR: ("attenuation_color", 0.0, 1.0),
    Property.SPECULAR: ("specular", 0.0, 1.0),
    Property.SPECULAR_COLOR: ("specular_color", 0.0, MOST),
    Property.CLEARCOAT: ("clearcoat", 0.0, 1.0),
    Property.CLEARCOAT_ROUGHNESS: ("clearcoat_roughness", 0.0, 1.0),
    Property.SHEEN_COLOR: ("sheen_color", 0.0, 1.0),
    Property.SHEEN_ROUGHNESS: ("sheen_roughness", 0.0, 1.0),
    Property.IRIDESCENCE: ("iridescence", 0.0, 1.0),
    Property.IRIDESCENCE_IOR: ("iridescence_ior", 1.0, _LARGE),
    Property.IRIDESCENCE_LEAST: ("iridescence_least", 0.0, _LARGE),
    Property.IRIDESCENCE_MOST: ("iridescence_most", 0.0, _LARGE),
    Property.THROUGH: ("diffuse_transmission", 0.0, 1.0),
    Property.THROUGH_COLOR: ("diffuse_transmission_color", 0.0, 1.0),
}


def with_look(
    scene: Scene,
    motion: Motion,
    animation: Animation,
    time: float,
    dark: Collection[int] = (),
    pause: Pause = go_on,
) -> Scene:
    """`scene` with its materials and lights as an animation of its `motion` has them at `time` [s].

    A value outside of its range is the nearest one in it. A product changes where the animation has both its factors,
    a cone where it has both angles. dark: lights that do not shine; pause: called
    between steps that take long.
    """
    materials, lights = defaultdict[int, dict[Property, Doubles]](dict), defaultdict[int, dict[Property, Doubles]](dict)
    for index, channel in enumerate(animation.channels):
        if index % EVERY == 0:
            pause()
        if channel.changes in MATERIAL_PROPERTIES:
            materials[channel.part][channel.changes] = value_at(channel, time)
        elif channel.changes in LIGHT_PROPERTIES:
            lights[channel.part][channel.changes] = value_at(channel, time)
    if not (materials or lights or dark):
        return scene
    surfaces, punctual = list(scene.materials), list(scene.lights)
    for index, (number, values) in enumerate(materials.items()):
        if index % EVERY == 0:
            pause()
        surfaces[number] = _material(surfaces[number], values)
    for number, values in lights.items():
        punctual[number] = _light(punctual[number], values, motion.intensity_scale)
    for number in dark:
        punctual[number] = replace(punctual[number], intensity=(0.0, 0.0, 0.0))
    return with_path_light(replace(scene, materials=tuple(surfaces), lights=tuple(punctual)), scene)


def _material(material: Material, values: Values) -> Material:
    changed: dict[str, Any] = {}
    for changes in values.keys() & _FIELDS.keys():
        field, low, high = _FIELDS[changes]
        now = np.clip(values[changes], low, high).tolist()
        changed[field] = now[0] if len(now) == 1 else tuple(now)
    if Property.EMISSIVE in values and Property.EMISSIVE_STRENGTH in values:
        emission = _product(values[Property.EMISSIVE], values[Property.EMISSIVE_STRENGTH])
        changed["emission"] = triple(emission)
    return replace(material, **changed)


def _light(light: Light, values: Values, scale: float) -> Light:
    if Property.LIGHT_COLOR in values and Property.INTENSITY in values:
        intensity = _product(values[Property.LIGHT_COLOR], values[Property.INTENSITY])
        in_unit_space = intensity if light.kind is LightKind.DIRECTIONAL else intensity * scale
        light = replace(light, intensity=triple(in_unit_space))
    cones = Property.INNER_CONE in values and Property.OUTER_CONE in values
    if cones and light.kind is LightKind.SPOT:
        outer = float(np.clip(values[Property.OUTER_CONE][0], 0.0, pi / 2.0))
        inner = float(np.clip(values[Property.INNER_CONE][0], 0.0, outer))
        light = replace(light, cos_inner=cos(inner), cos_outer=cos(outer))
    return light


def _product(color: Doubles, factor: Doubles) -> Doubles:
    return np.asarray(np.clip(np.clip(color, 0.0, MOST) * np.clip(factor, 0.0, MOST), 0.0, MOST))

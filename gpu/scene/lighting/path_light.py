"""The light that light paths are drawn by: that of the file, where this still serves the light that edits make of it.

Light paths begin at lights in proportion to their power. If that were their power as edited, each edit of one light
would change the paths of all. So lights remember what they are drawn as, and what a path brings is scaled by what its
light is of that: dimming one is exact, and no path is traced for it. What lights are drawn as follows from the edits
alone, whatever came before, and so do pictures.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from gpu.scene.types import Doubles, Environment, Light, LightKind, Material, Rgb, Scene, Sky

# Of the square of half a scene's extent: directional lights and skies shine through the sphere around it.
_SPHERE = 0.75
_EVERY = 16  # of a picture's rows and columns, which tell its mean
Part = TypeVar("Part", Material, Light)


@dataclass(frozen=True)
class PathLightParameters:
    """least_efficiency: light paths that are spread by other powers than the lights' are worth fewer by this; if by
    less, they are spread by the lights' own, rounded to powers of `step` times the file's. least_channel: of a light's
    brightest channel, that any is drawn as: another colour may have what the file's has not.
    """

    least_efficiency: float = 0.25
    step: float = 4.0
    least_channel: float = 1e-12


PATH_LIGHT_PARAMETERS = PathLightParameters()


def with_path_light(lit: Scene, filed: Scene) -> Scene:
    """`lit`, whose lights are edited, with what they are drawn as; `filed`: the same with the light of its file."""
    now, before = _colors(lit), _colors(filed)
    if np.array_equal(now, before):
        return lit
    surfaces = slice(len(filed.materials))
    new_lamps = now[surfaces].any(axis=1) & ~before[surfaces].any(axis=1)
    power = _power_of_white(filed, filed.material_areas if new_lamps.any() else filed.light_areas)
    drawn = before
    if _efficiency(power * now.mean(axis=1), power * before.mean(axis=1)) < PATH_LIGHT_PARAMETERS.least_efficiency:
        drawn = _rounded(now, before, PATH_LIGHT_PARAMETERS.step)
    drawn = np.maximum(drawn, PATH_LIGHT_PARAMETERS.least_channel * drawn.max(axis=1, keepdims=True))
    colors: list[Rgb | None] = [None] * len(now)
    for part in np.flatnonzero((now != drawn).any(axis=1)):
        red, green, blue = drawn[part].tolist()
        colors[part] = red, green, blue
    sky = len(lit.materials)
    return lit.relit(
        _marked(lit.materials, colors[:sky]),
        _marked(lit.lights, colors[sky + 1 :]),
        None if lit.sky is None else replace(lit.sky, path_color=colors[sky]),
    )


def path_light(scene: Scene) -> Scene:
    """`scene` with its lights as light paths are drawn by them; itself where that is as they are."""
    marked = [part for part in (*scene.materials, *scene.lights, scene.sky) if part is not None]
    if all(part.path_color is None for part in marked):
        return scene
    materials = tuple(
        one if one.path_color is None else replace(one, emission=one.path_color, path_color=None)
        for one in scene.materials
    )
    lights = tuple(
        one if one.path_color is None else replace(one, intensity=one.path_color, path_color=None)
        for one in scene.lights
    )
    return replace(scene, materials=materials, lights=lights, sky=_path_sky(scene.sky))


def _path_sky(sky: Sky | Environment | None) -> Sky | Environment | None:
    if sky is None or sky.path_color is None:
        return sky
    if isinstance(sky, Environment):
        return replace(sky, tint=sky.path_color, path_color=None)
    return Sky(sky.path_color)


def path_light_shares(scene: Scene) -> Doubles:
    """What the light of each part of `scene` is of what it is drawn as, (part, 3): of its materials, which may emit,
    its sky and its lights, in this order.
    """
    parts = (*scene.materials, scene.sky, *scene.lights)
    shares = np.ones((len(parts), 3))
    for number, part in enumerate(parts):
        if part is not None and part.path_color is not None:
            drawn = np.array(part.path_color)
            shares[number] = np.array(_color(part)) / np.where(drawn > 0.0, drawn, 1.0)
    return shares


def _marked(parts: Sequence[Part], colors: Sequence[Rgb | None]) -> tuple[Part, ...]:
    pairs = zip(parts, colors, strict=True)
    return tuple(part if color == part.path_color else replace(part, path_color=color) for part, color in pairs)


def _color(part: Material | Light | Sky | Environment) -> Rgb:
    match part:
        case Material():
            return part.emission
        case Light():
            return part.intensity
        case Sky():
            return part.radiance
        case Environment():
            return part.tint


def _colors(scene: Scene) -> Doubles:
    """Of the lights of each part (part, 3), in the order of `path_light_shares`; black where it is none."""
    parts = (*scene.materials, scene.sky, *scene.lights)
    black = (0.0, 0.0, 0.0)
    return np.array([black if part is None or getattr(part, "unlit", False) else _color(part) for part in parts])


def _power_of_white(scene: Scene, areas: Doubles) -> Doubles:
    """About the power (part,) that each part has for each unit of its colour, in unit space; areas (material,)."""
    sides = [2.0 if material.double_sided else 1.0 for material in scene.materials]
    sky = 2.0 * np.pi**2 * _SPHERE
    if isinstance(scene.sky, Environment):
        sky *= 2.0 * float(scene.sky.pixels[::_EVERY, ::_EVERY].mean(dtype=np.float64))
    return np.concatenate([np.pi * np.array(sides) * areas, [sky], [_power(it) for it in scene.lights]])


def _power(light: Light) -> float:
    """Of a light of unit intensity."""
    match light.kind:
        case LightKind.DIRECTIONAL:
            return float(np.pi * _SPHERE)
        case LightKind.SPOT:
            return float(2.0 * np.pi * (1.0 - light.cos_outer))
        case _:
            return float(4.0 * np.pi)


def _efficiency(power: Doubles, drawn: Doubles) -> float:
    """What paths are worth that are spread by the powers `drawn` (part,), not by `power` (part,), which they bring."""
    if not power.any():
        return 1.0
    if not drawn[power > 0.0].all():
        return 0.0
    own, other = power / power.sum(), drawn / drawn.sum()
    return float(1.0 / np.divide(own**2, other, out=np.zeros_like(own), where=own > 0.0).sum())


def _rounded(now: Doubles, before: Doubles, step: float) -> Doubles:
    """The colours `before` (part, 3), or those of `now` where they are black, at about the brightness of `now`."""
    hue = np.where(before.any(axis=1, keepdims=True), before, now)
    old, new = hue.mean(axis=1), now.mean(axis=1)
    lit = new > 0.0
    factor = np.zeros(len(now))
    factor[lit] = step ** np.round(np.log(new[lit] / old[lit]) / np.log(step))
    own = ~before.any(axis=1) & lit  # of no file: the brightness itself is rounded
    factor[own] = step ** np.round(np.log(new[own]) / np.log(step)) / new[own]
    return hue * factor[:, None]

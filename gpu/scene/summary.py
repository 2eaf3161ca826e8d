"""What `lumenwalk info` says of a scene."""

from collections.abc import Callable, Iterator
from dataclasses import asdict
from math import atan, ceil, degrees, log10, pi
from typing import Any

import numpy as np

from gpu.scene.file_frame import FileFrame
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.lighting.emitted_power import emitted_power
from gpu.scene.parts import LightForm, lights_of, material_ids
from gpu.scene.types import Camera, Doubles, Environment, Light, LightKind, Scene, Sky, Texture

_LISTED = 40


def summarise(scene: Scene) -> dict[str, Any]:
    """The scene's contents as JSON-ready values: size [m], area [m²], power [W], irradiance [W/m²], radiance.

    Points and directions are in the file's own coordinates, which `frame` takes to metres; by `id` edits name things.
    """
    corners = scene.frame.to_file(np.array(scene.bounds))
    triangles = np.bincount(scene.triangle_material, minlength=len(scene.materials))
    return {
        "name": scene.name,
        "triangles": len(scene.triangles),
        "vertices": len(scene.vertices),
        "uv_sets": len(scene.uvs),
        "frame": {**asdict(scene.frame), "origin": list(scene.frame.origin)},
        "size": _list(np.ptp(np.array(scene.bounds), axis=0)),
        "bounds": {"min": _list(corners.min(axis=0)), "max": _list(corners.max(axis=0))},
        "materials": [
            {"id": one, "name": material.name, "triangles": int(count), "area": float(area)}
            for one, material, count, area in zip(
                material_ids(scene), scene.materials, triangles, _world_areas(scene), strict=True
            )
        ],
        "objects": [{"id": one} for one in scene.objects],
        "textures": [_texture(texture) for texture in scene.textures],
        "lights": _lights(scene),
        "addable": [part.id for part in lights_of(scene) if part.added],
        "cameras": [_camera(camera, scene.frame) for camera in scene.cameras],
        "animations": _animations(scene),
        "choices": {name: list(offered) for name, offered in scene.choices.items()},
        "memory_bytes": memory_bytes(scene),
        "dropped_triangles": scene.report.dropped_triangles,
        "ignored": list(scene.report.ignored),
        "notes": list(scene.report.notes),
    }


def _lights(scene: Scene) -> list[dict[str, Any]]:
    """Surfaces that emit, then punctual lights, then the sky."""
    ids = {
        (part.form is LightForm.SURFACE, part.form is LightForm.SKY, part.index): part.id for part in lights_of(scene)
    }
    found = [{"id": ids[True, False, index], **surface} for index, surface in _emitters(scene)]
    for index, light in enumerate(scene.lights):
        found.append({"id": ids[False, False, index], **_light(light, scene.placement.scale)})
    return found + ([{"id": ids[False, True, 0], **_sky(scene.sky)}] if scene.sky else [])


def _animations(scene: Scene) -> list[dict[str, Any]]:
    return [] if scene.motion is None else [{"id": it.id, "seconds": it.seconds} for it in scene.motion.animations]


def _sky(sky: Sky | Environment) -> dict[str, Any]:
    if isinstance(sky, Environment):
        brightest = sky.pixels.max(axis=(0, 1)) * np.array(sky.tint)
        return {"name": sky.name, "kind": "environment", "radiance": _list(brightest)}
    return {"name": "sky", "kind": "sky", "radiance": list(sky.radiance)}


def memory_bytes(scene: Scene) -> int:
    """Bytes of the scene's arrays; pixels that several textures share count once."""
    arrays = [scene.vertices, scene.normals, scene.uvs, scene.triangles, scene.triangle_material]
    arrays += [] if scene.colors is None else [scene.colors]
    arrays += [scene.sky.pixels] if isinstance(scene.sky, Environment) else []
    pixels = {id(texture.pixels): texture.pixels.nbytes for texture in scene.textures}
    return sum(array.nbytes for array in arrays) + sum(pixels.values())


def summary_text(summary: dict[str, Any]) -> str:
    """`summarise`'s result for people, one line a thing."""
    bounds, frame, size = summary["bounds"], summary["frame"], summary["size"]
    step = max(size) / frame["metres_per_unit"] / 1e4
    lines = [
        summary["name"],
        f"  {_counted(summary['triangles'], 'triangles')}, {summary['vertices']:,} vertices, "
        f"{_counted(summary['uv_sets'], 'UV sets')}",
        f"  size {_vector(size)} m, from {_point(bounds['min'], step)} to {_point(bounds['max'], step)} in the file",
        f"  +{frame['up'].upper()} is up, a unit is {frame['metres_per_unit']:.6g} m, "
        f"metres count from {_point(frame['origin'], step)}",
        f"  memory {summary['memory_bytes'] / 1e6:,.1f} MB",
    ]
    sections: dict[str, Callable[[Any], str]] = {
        "materials": lambda m: f"{m['id']}: {_counted(m['triangles'], 'triangles')}",
        "objects": lambda o: o["id"],
        "textures": lambda t: f"{t['name']}: {t['width']}×{t['height']}, {'colour' if t['srgb'] else 'data'}",
        "lights": _light_text,
        "cameras": lambda c: f"{c['name']}: {c['projection']} at {_point(c['position'], step)}",
        "animations": lambda a: f"{a['id']}: {a['seconds']:.3g} s",
    }
    for key, text in sections.items():
        entries = summary[key]
        lines.append(f"  {_counted(len(entries), key)}")
        lines += [f"    {text(entry)}" for entry in entries[:_LISTED]]
        lines += [f"    and {len(entries) - _LISTED} more"] if len(entries) > _LISTED else []
        if key == "lights" and summary["addable"]:
            lines.append(f"    edits can add: {', '.join(summary['addable'])}")
    lines += [f"  {name}: one of {', '.join(offered)}" for name, offered in summary["choices"].items()]
    if summary["dropped_triangles"]:
        lines.append(f"  dropped: {_counted(summary['dropped_triangles'], 'triangles')} without area")
    lines += [f"  ignored: {sentence}" for sentence in summary["ignored"]]
    lines += [f"  note: {sentence}" for sentence in summary["notes"]]
    return "\n".join(lines)


def _counted(count: int, things: str) -> str:
    return f"{count:,} {things.removesuffix('s') if count == 1 else things}"


def _world_areas(scene: Scene) -> Doubles:
    """The area (material,) of each material's surfaces in world units."""
    areas = np.linalg.norm(area_vectors(scene.vertices.astype(np.float64), scene.triangles), axis=1) / 2.0
    return np.bincount(scene.triangle_material, areas, len(scene.materials)) / scene.placement.scale**2


def _emitters(scene: Scene) -> Iterator[tuple[int, dict[str, Any]]]:
    """Materials that emit, by number, with their area and power."""
    found = zip(scene.materials, _world_areas(scene), emitted_power(scene), strict=True)
    for index, (material, area, power) in enumerate(found):
        if material.emits and area > 0.0:
            yield index, {"name": material.name, "kind": "area", "area": float(area), "power": _list(power)}


def _light(light: Light, scale: float) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": light.name, "kind": light.kind.name.lower()}
    if light.kind is LightKind.DIRECTIONAL:
        return {**entry, "irradiance": list(light.intensity)}
    solid_angle = 4.0 * pi
    if light.kind is LightKind.SPOT:  # the falloff between the cones is the square of a ramp over the cosine
        solid_angle = 2.0 * pi * (1.0 - light.cos_inner + (light.cos_inner - light.cos_outer) / 3.0)
    return {**entry, "power": _list(solid_angle * np.array(light.intensity) / scale**2)}


def _camera(camera: Camera, frame: FileFrame) -> dict[str, Any]:
    entry = {
        "name": camera.name,
        "projection": "orthographic" if camera.orthographic else "perspective",
        "position": _list(frame.to_file(camera.to_world[:3, 3])),
        "direction": _list(frame.turned_back(-camera.to_world[:3, 2])),
        "aspect": camera.aspect,
        "near": camera.near,
    }
    if camera.orthographic:
        return {**entry, "height": 2.0 * camera.half_height}
    return {**entry, "yfov_degrees": degrees(2.0 * atan(camera.half_height))}


def _texture(texture: Texture) -> dict[str, Any]:
    height, width, _ = texture.pixels.shape
    return {"name": texture.name, "width": width, "height": height, "srgb": texture.srgb}


def _light_text(light: dict[str, Any]) -> str:
    unit = {"power": "W", "irradiance": "W/m²", "radiance": "W/m²/sr"}
    amount = next(f"{_vector(light[key])} {unit[key]}" for key in unit if key in light)
    return f"{light['id']}: {light['kind']}, {amount}"


def _list(values: Doubles) -> list[float]:
    return [float(value) for value in values]


def _vector(values: Any) -> str:
    return " ".join(f"{value:.4g}" for value in values)


def _point(values: Any, step: float) -> str:
    """Coordinates to a decimal place that is no coarser than `step`, without zeros at their ends."""
    decimals = min(max(0, ceil(-log10(step))), 12) if step > 0.0 else 6
    return " ".join(np.format_float_positional(round(value, decimals) + 0.0, trim="-") for value in values)

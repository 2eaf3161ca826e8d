"""Checks between a loader and a device: what passes is finite, indexed in range and within the limits."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Camera, Light, Material, Texture, TextureSlot

FARTHEST = 1e100
"""Coordinates beyond this, and extents below its inverse, would overflow in float64 when areas are taken."""


def check_finite(source: str, field: str, values: NDArray[Any]) -> None:
    """Raise SceneError naming the first row of `values`, shape (row, …), that holds a NaN or an infinity."""
    if np.isfinite(values).all():
        return
    row = int(np.argmax(~np.isfinite(values.reshape(len(values), -1)).all(axis=1)))
    raise SceneError(source, f"{field}[{row}]", f"is not finite: {values[row].tolist()}; repair it in the file")


def check_size(source: str, field: str, values: NDArray[Any], limit: float) -> None:
    """Raise SceneError naming the first row of `values`, shape (row, …), with a number beyond ±`limit`."""
    if values.size and float(np.abs(values).max()) > limit:
        row = int(np.argmax((np.abs(values.reshape(len(values), -1)) > limit).any(axis=1)))
        raise SceneError(source, f"{field}[{row}]", f"is beyond ±{limit:g}: {values[row].tolist()}; scale it down")


def check_count(source: str, what: str, count: int, limit: int, setting: str) -> None:
    """Raise ForbiddenError when there are more than `limit` of `what`; `setting` is the limit's name in SceneLimits."""
    if count > limit:
        raise ForbiddenError(
            source, "", f"{count:,} {what}, more than the {limit:,} allowed; simplify it or raise {setting}"
        )


def check_indices(source: str, field: str, indices: NDArray[Any], count: int) -> None:
    """Raise SceneError naming the first row of `indices`, shape (row, …), that is not in [0, count)."""
    if indices.size and (int(indices.min()) < 0 or int(indices.max()) >= count):
        bad = ((indices < 0) | (indices >= count)).reshape(len(indices), -1).any(axis=1)
        row = int(np.argmax(bad))
        raise SceneError(source, f"{field}[{row}]", f"index out of range: {indices[row].tolist()}, there are {count}")


def check_textures(source: str, textures: Sequence[Texture], limits: SceneLimits) -> None:
    """Raise SceneError when a texture has no pixels, another layout than (height, width, 4) uint8, or is too large."""
    pixels = {id(texture.pixels): texture.pixels.size // 4 for texture in textures}
    check_count(source, "texture pixels", sum(pixels.values()), limits.max_texture_pixels, "max_texture_pixels")
    for number, texture in enumerate(textures):
        shape, field = texture.pixels.shape, f"textures[{number}]"
        if len(shape) != 3 or shape[2] != 4 or not texture.pixels.size or texture.pixels.dtype != np.uint8:
            raise SceneError(source, field, f"pixels are {shape} {texture.pixels.dtype}, not (height, width, 4) uint8")
        side = max(shape[:2])
        check_count(f"{source}: {field}", "pixels along one side", side, limits.max_texture_size, "max_texture_size")


def slots(material: Material) -> dict[str, TextureSlot]:
    """The texture slots that `material` uses, by field name."""
    values = {name: getattr(material, name) for name in vars(material) if name.endswith("_slot")}
    return {name: slot for name, slot in values.items() if slot is not None}


def check_materials(source: str, materials: Sequence[Material], textures: int, limits: SceneLimits) -> None:
    """Raise SceneError for a number that is not finite or negative, or a slot that names no texture or UV set."""
    check_count(source, "materials", len(materials), limits.max_materials, "max_materials")
    for number, material in enumerate(materials):
        for name, value in vars(material).items():
            field = f"materials[{number}].{name}"
            if isinstance(value, TextureSlot):
                check_indices(source, f"{field}.texture", np.array([value.texture]), textures)
                check_indices(source, f"{field}.uv_set", np.array([value.uv_set]), limits.max_uv_sets)
                check_finite(source, f"{field}.transform", np.array([value.transform]))
            elif isinstance(value, float | tuple):
                values = np.atleast_1d(np.asarray(value, float))
                if name != "attenuation_distance":
                    check_finite(source, field, values)
                if name not in ("normal_scale", "anisotropy_rotation") and not (values >= 0.0).all():
                    raise SceneError(source, field, f"must not be negative, but is {value}")


def check_lights(source: str, lights: Sequence[Light], limits: SceneLimits) -> None:
    """Raise SceneError for a light that is not finite, negative, without direction, or with cones out of order."""
    check_count(source, "lights", len(lights), limits.max_lights, "max_lights")
    for number, light in enumerate(lights):
        field = f"lights[{number}]"
        for name in ("intensity", "position", "direction"):
            check_finite(source, f"{field}.{name}", np.array(getattr(light, name), float))
        if min(light.intensity) < 0.0:
            raise SceneError(source, f"{field}.intensity", f"must not be negative, but is {light.intensity}")
        if not abs(np.linalg.norm(light.direction) - 1.0) < 1e-4:
            raise SceneError(source, f"{field}.direction", f"must have length 1, but is {light.direction}")
        if not -1.0 <= light.cos_outer <= light.cos_inner <= 1.0:
            raise SceneError(source, f"{field}", "the inner cone must not be wider than the outer one")


def check_cameras(source: str, cameras: Sequence[Camera], limits: SceneLimits) -> None:
    """Raise SceneError for a camera that is not finite or has no extent."""
    check_count(source, "cameras", len(cameras), limits.max_cameras, "max_cameras")
    for number, camera in enumerate(cameras):
        field = f"cameras[{number}]"
        check_finite(source, f"{field}.to_world", camera.to_world)
        check_finite(source, field, np.array([camera.half_height, camera.aspect, camera.near]))
        if camera.half_height <= 0.0 or camera.aspect <= 0.0:
            raise SceneError(source, field, "field of view and aspect ratio must be positive")

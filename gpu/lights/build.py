"""Makes the table of a scene's emitters."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.constants import PI
from gpu.core.device import duplicate, launch, layout_of, struct_array
from gpu.device_scene.data import EnvironmentData, SceneData
from gpu.device_scene.features import MAX_ENUMERATED
from gpu.device_scene.sides import emits_from_back
from gpu.device_scene.surface import emitted_at
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_table import LightData, LightTable, PowerCdf
from gpu.lights.sun_map import no_sun_maps
from gpu.sampling.warps import triangle_barycentrics
from gpu.scene.types import Doubles, Environment, Ints, Light, LightKind, Rgb, Sky, same_emission, same_sky


@wp.kernel
def triangle_power_kernel(first: int, scene: SceneData, faces: wp.array[int], samples: int, areas: wp.array[float],
                          powers: wp.array[float]) -> None:  # fmt: skip
    """One thread an emissive triangle of `faces`: its area [unit area] and the power [W] of the sides that emit,
    averaged over `samples` points and all channels; (triangle,) each.
    """
    index = first + wp.tid()
    face = faces[index]
    corner = scene.triangles[face]
    p0 = scene.vertices[corner[0]]
    area = 0.5 * wp.length(wp.cross(scene.vertices[corner[1]] - p0, scene.vertices[corner[2]] - p0))
    total = float(0.0)
    for k in range(samples):
        # A lattice of rank one; the texture's mean over the triangle is all that is wanted.
        uv = triangle_barycentrics((float(k) + 0.5) / float(samples), (float(k) * 0.618034) % 1.0)
        emission = emitted_at(scene, face, uv[0], uv[1])
        total += (emission[0] + emission[1] + emission[2]) / 3.0
    factor = scene.materials[scene.triangle_material[face]].emission
    # A floor, so that no point that emits is left without a chance to be chosen.
    total = wp.max(total / float(samples), 0.01 * wp.max(factor[0], wp.max(factor[1], factor[2])))
    areas[index] = area
    powers[index] = wp.where(emits_from_back(scene, face), 2.0, 1.0) * PI * area * total


_LIGHT = layout_of(LightData)


def _lights(lights: Sequence[Light], device: wp.Device) -> wp.array:
    """`lights` as kernels take them; one that nobody reads where there are none."""
    rows = np.zeros(max(len(lights), 1), _LIGHT)
    for row, light in zip(rows, lights, strict=False):
        row["kind"], row["cos_inner"], row["cos_outer"] = int(light.kind), light.cos_inner, light.cos_outer
        row["intensity"], row["position"], row["direction"] = light.intensity, light.position, light.direction
    return struct_array(LightData, rows, device)


def _light_power(light: Light, radius: float) -> float:
    """Power of a punctual light [W], the mean of the channels; a directional one's through the scene's sphere."""
    intensity = float(np.mean(light.intensity))
    if light.kind is LightKind.DIRECTIONAL:
        return intensity * np.pi * radius**2
    if light.kind is LightKind.SPOT:
        return intensity * 2.0 * np.pi * (1.0 - light.cos_outer)
    return intensity * 4.0 * np.pi


def _sky_power(sky: Sky | Environment, picture: EnvironmentData, radius: float) -> float:
    """Power of the sky [W], the mean of the channels, through the scene's sphere; picture: of an environment."""
    if isinstance(sky, Environment):
        mean = float(picture.mean.numpy()[0]) * float(np.mean(sky.tint))
    else:
        mean = float(np.mean(sky.radiance)) / 2.0
    return 4.0 * np.pi * mean * np.pi * radius**2


def emissive_faces(device_scene: DeviceScene) -> Ints:
    """The device's triangles whose material emits light, shape (triangle,). Unlit materials are shown, not lights."""
    by_material = zip(device_scene.scene.materials, device_scene.faces_by_material, strict=True)
    faces = [faces for material, faces in by_material if material.emits]
    return np.sort(np.concatenate(faces)) if faces else np.zeros(0, np.int32)


def power_cdf(power: Doubles, device: wp.Device) -> PowerCdf:
    """Choice in proportion to `power` (emitter,), or of any alike when none has any."""
    cdf = PowerCdf()
    cdf.count = len(power)
    shares = power if power.any() else np.ones(max(len(power), 1))
    ends = np.cumsum(shares) / float(shares.sum())
    integers = np.minimum(np.floor(ends * 2**32), 2**32 - 1).astype(np.uint32)
    cdf.cumulative = wp.array(integers, dtype=wp.uint32, device=device)
    return cdf


def probabilities(cdf: PowerCdf) -> Doubles:
    """Of each choice, (emitter,)."""
    return np.diff(cdf.cumulative.numpy().astype(np.float64), prepend=0.0) / 2.0**32


@dataclass(frozen=True)
class Emitters:
    """Their `table`, and on the host the powers (emitter,) of those that are extended, triangles and sky [W]."""

    table: LightTable
    powers: Doubles


def build_light_table(device_scene: DeviceScene) -> LightTable:
    """The table of the scene's emitters."""
    return emitters_of(device_scene).table


def emitters_of(
    device_scene: DeviceScene, *, power_samples: int = 16, mask_samples: int = 256, min_solid_angle: float = 0.1
) -> Emitters:
    """The scene's emitters, to be chosen in proportion to their power.

    power_samples: points of a triangle whose emission tells its power, in scenes with masks as many as mask_samples;
    min_solid_angle: see LightTable [sr].
    """
    scene, device = device_scene.scene, device_scene.device
    faces = wp.array(emissive_faces(device_scene), dtype=wp.int32, device=device)
    table = LightTable()
    radius = device_scene.solid_radius
    table.radius = wp.array([radius], dtype=float, device=device)
    table.min_solid_angle = min_solid_angle
    table.suns = no_sun_maps(device)
    table.triangle_count, table.sky_count = len(faces), int(scene.sky is not None)
    table.faces = faces
    table.areas = wp.zeros(len(faces), dtype=float, device=device)
    powers = wp.zeros(len(faces), dtype=float, device=device)
    samples = mask_samples if device_scene.data.alpha else power_samples
    launch(triangle_power_kernel, len(faces), [device_scene.data, faces, samples, table.areas, powers], device)
    sky = [_sky_power(scene.sky, device_scene.data.environment, radius)] if scene.sky else []
    emitters = Emitters(table, np.concatenate([powers.numpy().astype(np.float64), sky]))
    table.lights = _lights(scene.lights, device)
    _choose_by_power(emitters, device_scene)
    return emitters


def _choose_by_power(emitters: Emitters, device_scene: DeviceScene) -> None:
    """Have the emitters of a table, whose lights are those of the scene, chosen by their powers."""
    table, lights, device = emitters.table, device_scene.scene.lights, device_scene.device
    powers = [_light_power(light, device_scene.solid_radius) for light in lights]
    table.light_count = len(lights)
    table.all_emitters = power_cdf(np.concatenate([emitters.powers, powers]), device)
    table.count = table.all_emitters.count
    table.sampled = table.all_emitters
    if len(lights) <= MAX_ENUMERATED:
        table.enumerated_count = len(lights)
        table.sampled = power_cdf(emitters.powers, device)


def emitters_after(emitters: Emitters, before: DeviceScene, now: DeviceScene) -> Emitters:
    """The emitters of `now`, another state of the scene of `before`, which has `emitters`: these where no light
    differs, in the same arrays but for what differs with lights where no triangle and no sky has another power.
    """
    if not _same_extended(before, now):
        return emitters_of(now)
    old, new = before.scene.lights, now.scene.lights
    if old == new:
        return emitters
    found = Emitters(duplicate(LightTable, emitters.table), emitters.powers)
    found.table.lights = _lights(new, now.device)
    if [_power_of(light) for light in old] != [_power_of(light) for light in new]:
        _choose_by_power(found, now)
    return found


def _power_of(light: Light) -> tuple[LightKind, Rgb, float]:
    """What tells the power of a light."""
    return light.kind, light.intensity, light.cos_outer


def _same_extended(before: DeviceScene, now: DeviceScene) -> bool:
    """Whether triangles that emit are as many in two states of a scene, with the same powers, areas and numbers, and so
    is the sky.
    """
    one, other = before.scene, now.scene
    if one.triangles is not other.triangles or before.triangle_order is not now.triangle_order:
        return False
    if not (same_sky(one.sky, other.sky) and same_emission(one.materials, other.materials)):
        return False
    if one.vertices is other.vertices:
        return True
    corners = other.triangles[now.triangle_order[emissive_faces(now)]]
    return before.solid_radius == now.solid_radius and np.array_equal(one.vertices[corners], other.vertices[corners])

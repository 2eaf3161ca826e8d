"""All that emits: emissive triangles, punctual lights and the sky in one table, sampled in proportion to power."""

import numpy as np
import warp as wp

from gpu.device import launch
from gpu.resident import ResidentScene, SceneData
from gpu.sampling import (
    PI,
    TO_UNIT,
    Pair,
    cone_direction,
    cosine_direction,
    on_disk,
    orthonormal,
    sky_direction,
    triangle_barycentrics,
)
from gpu.scene.types import Ints, Light, LightKind
from gpu.surface import emission_at, triangle_normal

POINT = wp.constant(int(LightKind.POINT))
SPOT = wp.constant(int(LightKind.SPOT))
DIRECTIONAL = wp.constant(int(LightKind.DIRECTIONAL))
# Lights without a place stand this far away; unit space has the diameter √3.
FAR = wp.constant(4.0)
POWER_SAMPLES = wp.constant(16)


@wp.struct
class LightData:
    """A punctual light; see gpu.scene.types.Light."""

    kind: int
    intensity: wp.vec3
    position: wp.vec3
    direction: wp.vec3
    cos_inner: float
    cos_outer: float


@wp.struct
class LightTable:
    """Emitters: `triangle_count` emissive triangles, then `light_count` punctual lights, then the sky if there is one.

    cumulative (emitter,): upper ends of the emitters' shares of 2³² in the choice by power; faces, areas (triangle,);
    radius: of the scene's bounding sphere about the origin.
    """

    count: int
    triangle_count: int
    light_count: int
    cumulative: wp.array[wp.uint32]
    faces: wp.array[int]
    areas: wp.array[float]
    lights: wp.array[LightData]
    radius: float


@wp.struct
class EmitterChoice:
    """An emitter and the probability that it is chosen with."""

    index: int
    probability: float


@wp.struct
class Particle:
    """A light particle: where it starts (with the surface's normal, or zero), its unit direction and flux [W]."""

    origin: wp.vec3
    normal: wp.vec3
    direction: wp.vec3
    flux: wp.vec3


@wp.struct
class LightSample:
    """A sample of the light that reaches a point: towards `direction`, from `distance` away, at a surface of `normal`.

    irradiance: radiance × solid angle ÷ density [W/m²], still to be multiplied by the receiver's cosine.
    """

    direction: wp.vec3
    distance: float
    normal: wp.vec3
    irradiance: wp.vec3


@wp.func
def sky_radiance(scene: SceneData, direction: wp.vec3) -> wp.vec3:
    """Radiance that arrives from unit `direction` where no surface is [W/m²/sr]."""
    return scene.sky * (0.5 + 0.5 * direction[1])


@wp.func
def spot_falloff(light: LightData, direction: wp.vec3) -> float:
    """Share of a spot light's intensity in unit `direction` (glTF KHR_lights_punctual, inner and outer cone angles)."""
    width = wp.max(light.cos_inner - light.cos_outer, 1.0e-4)
    share = wp.clamp((wp.dot(direction, light.direction) - light.cos_outer) / width, 0.0, 1.0)
    return share * share


@wp.func
def choose_emitter(table: LightTable, value: wp.uint32) -> EmitterChoice:
    """The emitter whose share of 2³² holds `value`."""
    low = int(0)
    high = table.count - 1
    while low < high:
        middle = (low + high) // 2
        if value < table.cumulative[middle]:
            high = middle
        else:
            low = middle + 1
    below = wp.uint32(0)
    if low > 0:
        below = table.cumulative[low - 1]
    above = float(table.cumulative[low] - below)
    if low == table.count - 1:
        above += 1.0  # the last share ends at 2³², which is stored as 2³² − 1
    choice = EmitterChoice()
    choice.index = low
    choice.probability = above * TO_UNIT
    return choice


@wp.func
def point_on(scene: SceneData, face: int, place: wp.vec2) -> wp.vec3:
    """The point of a triangle with barycentrics `place`."""
    corner = scene.triangles[face]
    return (
        scene.vertices[corner[0]] * place[0]
        + scene.vertices[corner[1]] * place[1]
        + scene.vertices[corner[2]] * (1.0 - place[0] - place[1])
    )


@wp.func
def emit(scene: SceneData, table: LightTable, pick: wp.uint32, place: Pair, way: Pair) -> Particle:
    """A light particle whose expected flux is all the scene's light; Jensen 1996, light particles by power."""
    choice = choose_emitter(table, pick)
    particle = Particle()
    if choice.index < table.triangle_count:
        face = table.faces[choice.index]
        uv = triangle_barycentrics(place.x, place.y)
        particle.origin = point_on(scene, face, uv)
        particle.normal = triangle_normal(scene, face)
        particle.direction = cosine_direction(particle.normal, way.x, way.y)
        power = PI * table.areas[choice.index] / choice.probability
        particle.flux = emission_at(scene, face, uv[0], uv[1]) * power
        return particle
    if choice.index < table.triangle_count + table.light_count:
        light = table.lights[choice.index - table.triangle_count]
        if light.kind == DIRECTIONAL:
            disk = on_disk(place.x, place.y) * table.radius
            frame = orthonormal(light.direction)
            particle.origin = frame * wp.vec3(disk[0], disk[1], -FAR)
            particle.direction = light.direction
            particle.flux = light.intensity * (PI * table.radius * table.radius / choice.probability)
            return particle
        cos_angle = wp.where(light.kind == SPOT, light.cos_outer, -1.0)
        particle.origin = light.position
        particle.direction = cone_direction(light.direction, cos_angle, way.x, way.y)
        share = wp.where(light.kind == SPOT, spot_falloff(light, particle.direction), 1.0)
        particle.flux = light.intensity * (share * 2.0 * PI * (1.0 - cos_angle) / choice.probability)
        return particle
    disk = on_disk(place.x, place.y) * table.radius
    particle.direction = -sky_direction(way.x, way.y)
    particle.origin = orthonormal(particle.direction) * wp.vec3(disk[0], disk[1], -FAR)
    particle.flux = scene.sky * (2.0 * PI * PI * table.radius * table.radius / choice.probability)
    return particle


@wp.func
def sample_light(scene: SceneData, table: LightTable, position: wp.vec3, pick: wp.uint32, place: Pair) -> LightSample:
    """A sample of the light that reaches `position` from the emitters, visibility left to the caller."""
    choice = choose_emitter(table, pick)
    sample = LightSample()
    if choice.index < table.triangle_count:
        face = table.faces[choice.index]
        uv = triangle_barycentrics(place.x, place.y)
        sample.normal = triangle_normal(scene, face)
        way = point_on(scene, face, uv) - position
        sample.distance = wp.length(way)
        if sample.distance > 0.0:
            sample.direction = way / sample.distance
            cosine = wp.max(-wp.dot(sample.direction, sample.normal), 0.0)
            area = table.areas[choice.index] / (sample.distance * sample.distance * choice.probability)
            sample.irradiance = emission_at(scene, face, uv[0], uv[1]) * (cosine * area)
        return sample
    if choice.index < table.triangle_count + table.light_count:
        light = table.lights[choice.index - table.triangle_count]
        if light.kind == DIRECTIONAL:
            sample.direction = -light.direction
            sample.distance = FAR
            sample.irradiance = light.intensity / choice.probability
            return sample
        way = light.position - position
        sample.distance = wp.length(way)
        if sample.distance > 0.0:
            sample.direction = way / sample.distance
            share = wp.where(light.kind == SPOT, spot_falloff(light, -sample.direction), 1.0)
            sample.irradiance = light.intensity * (share / (sample.distance * sample.distance * choice.probability))
        return sample
    sample.direction = sky_direction(place.x, place.y)
    sample.distance = FAR
    sample.irradiance = scene.sky * (2.0 * PI / choice.probability)
    return sample


@wp.kernel
def triangle_power_kernel(first: int, scene: SceneData, faces: wp.array[int], areas: wp.array[float],
                          powers: wp.array[float]) -> None:  # fmt: skip
    """One thread an emissive triangle: its area and its power [W], averaged over points and colour channels."""
    index = first + wp.tid()
    face = faces[index]
    corner = scene.triangles[face]
    p0 = scene.vertices[corner[0]]
    area = 0.5 * wp.length(wp.cross(scene.vertices[corner[1]] - p0, scene.vertices[corner[2]] - p0))
    total = float(0.0)
    for k in range(POWER_SAMPLES):
        # A lattice of rank one; the texture's mean over the triangle is all that is wanted.
        uv = triangle_barycentrics((float(k) + 0.5) / float(POWER_SAMPLES), (float(k) * 0.618034) % 1.0)
        emission = emission_at(scene, face, uv[0], uv[1])
        total += (emission[0] + emission[1] + emission[2]) / 3.0
    factor = scene.materials[scene.triangle_material[face]].emission
    # A floor, so that no point that emits is left without a chance to be chosen.
    total = wp.max(total / float(POWER_SAMPLES), 0.01 * wp.max(factor[0], wp.max(factor[1], factor[2])))
    areas[index] = area
    powers[index] = PI * area * total


def _light(light: Light) -> LightData:
    data = LightData()
    data.kind, data.cos_inner, data.cos_outer = int(light.kind), light.cos_inner, light.cos_outer
    data.intensity = wp.vec3(*light.intensity)
    data.position, data.direction = wp.vec3(*light.position), wp.vec3(*light.direction)
    return data


def _light_power(light: Light, radius: float) -> float:
    """Power of a punctual light [W], the mean of the channels; a directional one's through the scene's sphere."""
    intensity = float(np.mean(light.intensity))
    if light.kind is LightKind.DIRECTIONAL:
        return intensity * np.pi * radius**2
    if light.kind is LightKind.SPOT:
        return intensity * 2.0 * np.pi * (1.0 - light.cos_outer)
    return intensity * 4.0 * np.pi


def emissive_faces(resident: ResidentScene) -> Ints:
    """The device's triangles whose material emits light, shape (triangle,). Unlit materials are shown, not lights."""
    emits = np.array([max(m.emission) > 0.0 and not m.unlit for m in resident.scene.materials])
    materials = resident.scene.triangle_material[resident.triangle_order]
    return np.flatnonzero(emits[materials]).astype(np.int32)


def build_light_table(resident: ResidentScene) -> LightTable:
    """The scene's emitters with their shares in the choice by power; `count` is 0 when nothing emits."""
    scene, device = resident.scene, resident.device
    faces = wp.array(emissive_faces(resident), dtype=wp.int32, device=device)
    table = LightTable()
    table.radius = float(np.linalg.norm(np.abs(scene.vertices).max(axis=0)))
    table.triangle_count, table.light_count = len(faces), len(scene.lights)
    table.faces = faces
    table.areas = wp.zeros(len(faces), dtype=float, device=device)
    powers = wp.zeros(len(faces), dtype=float, device=device)
    launch(triangle_power_kernel, len(faces), [resident.data, faces, table.areas, powers], device)
    table.lights = wp.array([_light(light) for light in scene.lights] or [LightData()], dtype=LightData, device=device)
    shares = [powers.numpy().astype(np.float64), [_light_power(light, table.radius) for light in scene.lights]]
    if scene.sky is not None:
        shares.append([float(np.mean(scene.sky.radiance)) * 2.0 * (np.pi * table.radius) ** 2])
    power = np.concatenate(shares)
    total = power.sum()
    table.count = len(power) if total > 0.0 else 0
    ends = np.cumsum(power) / total if total > 0.0 else np.ones(1)
    table.cumulative = wp.array(
        np.minimum(np.floor(ends * 2**32), 2**32 - 1).astype(np.uint32), dtype=wp.uint32, device=device
    )
    return table

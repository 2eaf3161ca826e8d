"""All that emits: emissive triangles, the sky and punctual lights in one table, sampled in proportion to power."""

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
from gpu.scene.types import Doubles, Ints, Light, LightKind
from gpu.surface import emission_at, triangle_normal

SPOT = wp.constant(int(LightKind.SPOT))
DIRECTIONAL = wp.constant(int(LightKind.DIRECTIONAL))
# Lights without a place stand this far away; unit space has the diameter √3.
FAR = wp.constant(4.0)
NOT_AN_EMITTER = wp.constant(-1)
POWER_SAMPLES = wp.constant(16)
# So many punctual lights are cheaper to visit one by one than the noise of a choice among them.
MAX_VISITED = 8


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
class Shares:
    """The first `count` emitters' shares in a choice by power. cumulative (emitter,): their upper ends, of 2³²."""

    count: int
    cumulative: wp.array[wp.uint32]


@wp.struct
class LightTable:
    """Emitters: `triangle_count` emissive triangles, then the sky (`sky_count` is 0 or 1), then punctual lights.

    light_count: of the last; everything: shares of all emitters; sampled: of those that direct light chooses from; the
    first `visited_count` punctual lights it visits one by one instead. faces (triangle,) ascending; areas (triangle,);
    lights (light,); count: of all emitters, 0 when none has power; radius: of the scene's bounding sphere about the
    origin.
    """

    count: int
    triangle_count: int
    sky_count: int
    light_count: int
    visited_count: int
    everything: Shares
    sampled: Shares
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
def choose_emitter(shares: Shares, value: wp.uint32) -> EmitterChoice:
    """The emitter whose share of 2³² holds `value`."""
    low = int(0)
    high = shares.count - 1
    while low < high:
        middle = (low + high) // 2
        if value < shares.cumulative[middle]:
            high = middle
        else:
            low = middle + 1
    choice = EmitterChoice()
    choice.index = low
    choice.probability = share_of(shares, low)
    return choice


@wp.func
def share_of(shares: Shares, emitter: int) -> float:
    """The probability that an emitter is chosen with."""
    below = wp.uint32(0)
    if emitter > 0:
        below = shares.cumulative[emitter - 1]
    share = float(shares.cumulative[emitter] - below)
    if emitter == shares.count - 1:
        share += 1.0  # the last share ends at 2³², which is stored as 2³² − 1
    return share * TO_UNIT


@wp.func
def is_triangle(table: LightTable, emitter: int) -> bool:
    """Whether an emitter is a triangle."""
    return table.triangle_count > 0 and (table.sky_count + table.light_count == 0 or emitter < table.triangle_count)


@wp.func
def is_light(table: LightTable, emitter: int) -> bool:
    """Whether an emitter is a punctual light."""
    return table.light_count > 0 and (
        table.triangle_count + table.sky_count == 0 or emitter >= table.triangle_count + table.sky_count
    )


@wp.func
def emitter_of(table: LightTable, face: int) -> int:
    """The emitter that triangle `face` is, or NOT_AN_EMITTER."""
    low = int(0)
    high = table.triangle_count
    while low < high:
        middle = (low + high) // 2
        if table.faces[middle] < face:
            low = middle + 1
        else:
            high = middle
    if low < table.triangle_count and table.faces[low] == face:
        return low
    return NOT_AN_EMITTER


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
    choice = choose_emitter(table.everything, pick)
    particle = Particle()
    if is_triangle(table, choice.index):
        face = table.faces[choice.index]
        uv = triangle_barycentrics(place.x, place.y)
        particle.origin = point_on(scene, face, uv)
        particle.normal = triangle_normal(scene, face)
        particle.direction = cosine_direction(particle.normal, way.x, way.y)
        power = PI * table.areas[choice.index] / choice.probability
        particle.flux = emission_at(scene, face, uv[0], uv[1]) * power
        return particle
    if not is_light(table, choice.index):
        disk = on_disk(place.x, place.y) * table.radius
        particle.direction = -sky_direction(way.x, way.y)
        particle.origin = orthonormal(particle.direction) * wp.vec3(disk[0], disk[1], -FAR)
        particle.flux = scene.sky * (2.0 * PI * PI * table.radius * table.radius / choice.probability)
        return particle
    light = table.lights[choice.index - table.triangle_count - table.sky_count]
    if light.kind == DIRECTIONAL:
        disk = on_disk(place.x, place.y) * table.radius
        particle.origin = orthonormal(light.direction) * wp.vec3(disk[0], disk[1], -FAR)
        particle.direction = light.direction
        particle.flux = light.intensity * (PI * table.radius * table.radius / choice.probability)
        return particle
    cos_angle = wp.where(light.kind == SPOT, light.cos_outer, -1.0)
    particle.origin = light.position
    particle.direction = cone_direction(light.direction, cos_angle, way.x, way.y)
    share = wp.where(light.kind == SPOT, spot_falloff(light, particle.direction), 1.0)
    particle.flux = light.intensity * (share * 2.0 * PI * (1.0 - cos_angle) / choice.probability)
    return particle


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


def _shares(power: Doubles, device: wp.Device) -> Shares:
    """Shares in proportion to `power` (emitter,); `count` is 0 when there is none."""
    shares = Shares()
    total = float(power.sum())
    shares.count = len(power) if total > 0.0 else 0
    ends = np.cumsum(power) / total if total > 0.0 else np.ones(1)
    integers = np.minimum(np.floor(ends * 2**32), 2**32 - 1).astype(np.uint32)
    shares.cumulative = wp.array(integers, dtype=wp.uint32, device=device)
    return shares


def build_light_table(resident: ResidentScene) -> LightTable:
    """The scene's emitters with their shares in the choice by power; `count` is 0 when nothing emits."""
    scene, device = resident.scene, resident.device
    faces = wp.array(emissive_faces(resident), dtype=wp.int32, device=device)
    table = LightTable()
    table.radius = float(np.linalg.norm(np.abs(scene.vertices).max(axis=0)))
    table.triangle_count, table.sky_count = len(faces), int(scene.sky is not None)
    table.light_count = len(scene.lights)
    table.faces = faces
    table.areas = wp.zeros(len(faces), dtype=float, device=device)
    powers = wp.zeros(len(faces), dtype=float, device=device)
    launch(triangle_power_kernel, len(faces), [resident.data, faces, table.areas, powers], device)
    table.lights = wp.array([_light(light) for light in scene.lights] or [LightData()], dtype=LightData, device=device)
    sky = [] if scene.sky is None else [float(np.mean(scene.sky.radiance)) * 2.0 * (np.pi * table.radius) ** 2]
    extended = np.concatenate([powers.numpy().astype(np.float64), sky])
    power = np.concatenate([extended, [_light_power(light, table.radius) for light in scene.lights]])
    table.everything = _shares(power, device)
    table.count = table.everything.count
    if len(scene.lights) <= MAX_VISITED:
        table.visited_count = len(scene.lights)
        table.sampled = _shares(extended, device)
    else:
        table.sampled = table.everything
    return table

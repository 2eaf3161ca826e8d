"""All that emits: emissive triangles, the sky and punctual lights in one table, sampled in proportion to power."""

import warp as wp

from gpu.core.search import upper_bound
from gpu.device_scene.data import SceneData
from gpu.device_scene.environment import environment_radiance
from gpu.lights.sun_map import SunMaps
from gpu.sampling.sobol import TO_UNIT
from gpu.scene.types import LightKind

SPOT = wp.constant(int(LightKind.SPOT))
DIRECTIONAL = wp.constant(int(LightKind.DIRECTIONAL))
# Lights without a place stand this far away; unit space has the diameter √3.
FAR = wp.constant(4.0)
NOT_AN_EMITTER = wp.constant(-1)


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
class PowerCdf:
    """A choice among the first `count` emitters by power: emitter i has the values from cumulative[i − 1] to
    cumulative[i] of 2³².
    """

    count: int
    cumulative: wp.array[wp.uint32]


@wp.struct
class LightTable:
    """Emitters: `triangle_count` emissive triangles, then the sky (`sky_count` is 0 or 1), then `light_count` punctual
    lights; `count` in all.

    all_emitters: the choice among all of them; sampled: that among those which direct light samples. The first
    `enumerated_count` punctual lights it visits one by one instead. faces (triangle,): ascending; areas (triangle,);
    lights (light,); radius (1,): of the scene's bounding sphere about the origin, in unit space. min_solid_angle:
    triangles that are seen larger than this [sr] are sampled by solid angle, which takes longer than by area. suns:
    where light paths of the first punctual lights begin.
    """

    count: int
    triangle_count: int
    sky_count: int
    light_count: int
    enumerated_count: int
    all_emitters: PowerCdf
    sampled: PowerCdf
    faces: wp.array[int]
    areas: wp.array[float]
    lights: wp.array[LightData]
    radius: wp.array[float]
    min_solid_angle: float
    suns: SunMaps


@wp.struct
class EmitterChoice:
    """An emitter and the probability that it is chosen with."""

    index: int
    probability: float


@wp.func
def sky_radiance(scene: SceneData, direction: wp.vec3) -> wp.vec3:
    """Radiance that arrives from unit `direction` where no surface is [W/m²/sr]."""
    if scene.has_environment:
        return wp.cw_mul(environment_radiance(scene.environment, direction), scene.sky[0])
    return scene.sky[0] * (0.5 + 0.5 * direction[1])


@wp.func
def spot_falloff(light: LightData, direction: wp.vec3) -> float:
    """Share of a spot light's intensity in unit `direction` (glTF KHR_lights_punctual, inner and outer cone angles)."""
    width = wp.max(light.cos_inner - light.cos_outer, 1.0e-4)
    share = wp.clamp((wp.dot(direction, light.direction) - light.cos_outer) / width, 0.0, 1.0)
    return share * share


@wp.func
def choose_emitter(cdf: PowerCdf, value: wp.uint32) -> EmitterChoice:
    """The emitter that has `value` of 2³²."""
    choice = EmitterChoice()
    choice.index = upper_bound(cdf.cumulative, cdf.count - 1, value)
    choice.probability = probability_of(cdf, choice.index)
    return choice


@wp.func
def probability_of(cdf: PowerCdf, emitter: int) -> float:
    """The probability that an emitter is chosen with."""
    below = wp.uint32(0)
    if emitter > 0:
        below = cdf.cumulative[emitter - 1]
    share = float(cdf.cumulative[emitter] - below)
    if emitter == cdf.count - 1:
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
    emitter = upper_bound(table.faces, table.triangle_count, face - 1)
    if emitter < table.triangle_count and table.faces[emitter] == face:
        return emitter
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

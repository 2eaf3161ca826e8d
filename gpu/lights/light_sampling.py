"""Samples of the light that reaches a point, and their densities, which multiple importance sampling needs."""

import warp as wp

from gpu.core.constants import PI
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.environment import environment_density, sample_environment
from gpu.device_scene.rays import backdrop_hit
from gpu.device_scene.sides import emitting_normal
from gpu.device_scene.surface import emission_at, emitted_at
from gpu.lights.light_table import (
    DIRECTIONAL,
    FAR,
    NOT_AN_EMITTER,
    SPOT,
    LightData,
    LightTable,
    PowerCdf,
    choose_emitter,
    emitter_of,
    is_light,
    is_triangle,
    point_on,
    probability_of,
    sky_radiance,
    spot_falloff,
)
from gpu.sampling.sobol import BELOW_ONE, TO_UNIT, Pair
from gpu.sampling.spherical_triangle import Corners, triangle_direction, triangle_solid_angle
from gpu.sampling.warps import sky_direction, triangle_barycentrics

# Points less than this above an emitter's plane are on it, for all that float32 knows.
MIN_HEIGHT = wp.constant(1.0e-6)


@wp.struct
class LightSample:
    """A sample of the light that reaches a place: from `point`, on a surface of `normal` (zero: on none).

    direction: unit, towards the point; irradiance: radiance × solid_angle [W/m²], still to be multiplied by the
    receiver's cosine; solid_angle: that the sample stands for, the inverse of its density [sr], 0 for punctual lights.
    """

    point: wp.vec3
    normal: wp.vec3
    direction: wp.vec3
    irradiance: wp.vec3
    solid_angle: float


@wp.struct
class HitLight:
    """Light at a ray's hit: its radiance, and the density [1/sr] with which `sample_light` chooses that direction."""

    radiance: wp.vec3
    density: float


@wp.func
def punctual_sample(light: LightData, position: wp.vec3) -> LightSample:
    """The light that reaches `position` from a punctual light, as if nothing were in between."""
    sample = LightSample()
    if light.kind == DIRECTIONAL:
        sample.direction = -light.direction
        sample.point = position + sample.direction * FAR
        sample.irradiance = light.intensity
        return sample
    sample.point = light.position
    to_light = light.position - position
    distance = wp.length(to_light)
    if distance > 0.0:
        sample.direction = to_light / distance
        share = wp.where(light.kind == SPOT, spot_falloff(light, -sample.direction), 1.0)
        sample.irradiance = light.intensity * (share / (distance * distance))
    return sample


@wp.func
def corners_from(scene: SceneData, face: int, position: wp.vec3) -> Corners:
    """A triangle's corners as seen from `position`."""
    corner = scene.triangles[face]
    corners = Corners()
    corners.a = wp.normalize(scene.vertices[corner[0]] - position)
    corners.b = wp.normalize(scene.vertices[corner[1]] - position)
    corners.c = wp.normalize(scene.vertices[corner[2]] - position)
    return corners


@wp.func
def solid_angle_from(scene: SceneData, face: int, normal: wp.vec3, position: wp.vec3, corners: Corners) -> float:
    """The solid angle [sr] of a triangle's side of `normal` that `position` sees so; none from its own plane, where it
    is not defined.
    """
    height = wp.dot(position - scene.vertices[scene.triangles[face][0]], normal)
    return wp.where(height > MIN_HEIGHT, wp.abs(triangle_solid_angle(corners)), 0.0)


@wp.func
def barycentrics_towards(scene: SceneData, face: int, position: wp.vec3, direction: wp.vec3) -> wp.vec2:
    """Barycentrics of the triangle's point that `position` sees in `direction`."""
    corner = scene.triangles[face]
    p0 = scene.vertices[corner[0]] - position
    p1 = scene.vertices[corner[1]] - position
    p2 = scene.vertices[corner[2]] - position
    turn = wp.where(wp.dot(direction, wp.cross(p1 - p0, p2 - p0)) > 0.0, 1.0, -1.0)
    u = wp.max(turn * wp.dot(direction, wp.cross(p1, p2)), 0.0)
    v = wp.max(turn * wp.dot(direction, wp.cross(p2, p0)), 0.0)
    w = wp.max(turn * wp.dot(direction, wp.cross(p0, p1)), 0.0)
    return wp.vec2(u, v) / (u + v + w)


@wp.func
def triangle_density(table: LightTable, emitter: int, probability: float, solid_angle: float, normal: wp.vec3,
                     to_light: wp.vec3) -> float:  # fmt: skip
    """Density [1/sr] with which `sample_light` chooses the point of an emissive triangle at `to_light`; 0 from behind.

    to_light: from the receiver; probability: of the triangle; solid_angle: of all of it [sr].
    """
    if solid_angle > table.min_solid_angle:
        return probability / solid_angle
    facing = -wp.dot(to_light, normal)
    if facing <= 0.0:
        return 0.0
    square = wp.length_sq(to_light)
    return probability * square * wp.sqrt(square) / (table.areas[emitter] * facing)


@wp.func
def place_in_sky(place: Pair, pick: wp.uint32) -> Pair:
    """`place`, moved by a fraction of 2³² along a lattice: eight strata of `pick` have eight places far apart, of which
    the receiver's cosine may choose. (1, 5) generates Fibonacci's lattice of eight points.
    """
    moved = Pair()
    moved.a = place.a + pick
    moved.b = place.b + pick * wp.uint32(5)
    moved.x = wp.min(float(moved.a) * TO_UNIT, BELOW_ONE)
    moved.y = wp.min(float(moved.b) * TO_UNIT, BELOW_ONE)
    return moved


@wp.func
def sample_light(scene: SceneData, table: LightTable, cdf: PowerCdf, position: wp.vec3, pick: wp.uint32,
                 place: Pair) -> LightSample:  # fmt: skip
    """A sample of the light that reaches `position` from the emitters of `cdf`, as if nothing were in between."""
    choice = choose_emitter(cdf, pick)
    if is_light(table, choice.index):
        sample = punctual_sample(table.lights[choice.index - table.triangle_count - table.sky_count], position)
        sample.irradiance = sample.irradiance / choice.probability
        return sample
    sample = LightSample()
    if is_triangle(table, choice.index):
        face = table.faces[choice.index]
        corners = corners_from(scene, face, position)
        sample.normal = emitting_normal(scene, face, position - scene.vertices[scene.triangles[face][0]])
        solid_angle = solid_angle_from(scene, face, sample.normal, position, corners)
        uv = triangle_barycentrics(place.x, place.y)
        if solid_angle > table.min_solid_angle:
            direction = triangle_direction(corners, solid_angle, place.x, place.y)
            uv = barycentrics_towards(scene, face, position, direction)
        sample.point = point_on(scene, face, uv)
        to_light = sample.point - position
        sample.direction = wp.normalize(to_light)
        density = triangle_density(table, choice.index, choice.probability, solid_angle, sample.normal, to_light)
        if density > 0.0:
            sample.solid_angle = 1.0 / density
            sample.irradiance = emitted_at(scene, face, uv[0], uv[1]) * sample.solid_angle
        return sample
    if scene.has_environment:
        drawn = sample_environment(scene.environment, place_in_sky(place, pick))
        sample.direction = drawn.direction
        sample.point = position + drawn.direction * FAR
        sample.solid_angle = 1.0 / (drawn.density * choice.probability)
        sample.irradiance = sky_radiance(scene, drawn.direction) * sample.solid_angle
        return sample
    above = place_in_sky(place, pick)
    sample.direction = sky_direction(above.x, above.y)
    sample.point = position + sample.direction * FAR
    sample.irradiance = scene.sky[0] * (2.0 * PI / choice.probability)
    sample.solid_angle = 4.0 * PI / (wp.max(1.0 + sample.direction[1], 1.0e-6) * choice.probability)
    return sample


@wp.func
def sky_density(scene: SceneData, direction: wp.vec3) -> float:
    """Density [1/sr] with which `sample_light` chooses unit `direction`, once it has chosen the sky."""
    if scene.has_environment:
        return environment_density(scene.environment, direction)
    return (1.0 + direction[1]) / (4.0 * PI)


@wp.func
def light_at_hit(scene: SceneData, table: LightTable, cdf: PowerCdf, origin: wp.vec3, direction: wp.vec3,
                 met: Hit) -> HitLight:  # fmt: skip
    """The light that a ray along unit `direction` sees where it `met` a surface, or in the sky where it met none; `cdf`
    must have all emitters it can hit.
    """
    found = HitLight()
    hit = met
    if hit.face == NO_HIT:
        hit = backdrop_hit(scene, origin, direction)
        if hit.face != NO_HIT and emitter_of(table, hit.face) == NOT_AN_EMITTER:
            hit.face = NO_HIT  # a mere picture, which the sky's light passes
    if hit.face == NO_HIT:
        found.radiance = sky_radiance(scene, direction)
        if table.sky_count > 0:
            found.density = probability_of(cdf, table.triangle_count) * sky_density(scene, direction)
        return found
    emitter = emitter_of(table, hit.face)
    normal = emitting_normal(scene, hit.face, -direction)
    if emitter != NOT_AN_EMITTER and wp.dot(normal, direction) < 0.0:
        found.radiance = emission_at(scene, hit.face, hit.u, hit.v)
        corners = corners_from(scene, hit.face, origin)
        solid_angle = solid_angle_from(scene, hit.face, normal, origin, corners)
        to_light = direction * hit.t
        found.density = triangle_density(table, emitter, probability_of(cdf, emitter), solid_angle, normal, to_light)
    return found

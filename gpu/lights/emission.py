"""Light particles where they begin: a point of an emitter, chosen by power, a direction and a share of its flux."""

import warp as wp

from gpu.core.constants import PI
from gpu.device_scene.data import SceneData
from gpu.device_scene.environment import sample_environment
from gpu.device_scene.offsets import POINT_GAP
from gpu.device_scene.sides import emits_from_back, triangle_normal
from gpu.device_scene.surface import emitted_at
from gpu.lights.light_table import (
    DIRECTIONAL,
    FAR,
    SPOT,
    LightData,
    LightTable,
    choose_emitter,
    is_light,
    is_triangle,
    point_on,
    sky_radiance,
    spot_falloff,
)
from gpu.lights.sun_map import SunPlace, sun_place
from gpu.sampling.sobol import Pair
from gpu.sampling.warps import (
    cone_direction,
    cosine_direction,
    on_disk,
    orthonormal,
    sky_direction,
    triangle_barycentrics,
)

# How rays are drawn: given by a light; by the cosine from the normal; from anywhere alike on a disk far away.
GIVEN = wp.constant(0)
MATT = wp.constant(1)
FROM_AFAR = wp.constant(2)


@wp.struct
class Particle:
    """A light particle: where it starts (with the surface's normal, or zero), its unit direction and flux [W].

    light: the number of what emits it, as gpu.scene.lighting.path_light numbers the parts of a scene; spread: how its
    ray is drawn.
    """

    origin: wp.vec3
    normal: wp.vec3
    direction: wp.vec3
    flux: wp.vec3
    light: int
    spread: int


@wp.func
def sun_particle(table: LightTable, light: LightData, place: SunPlace, probability: float) -> Particle:
    """The particle of a directional light that begins at a place and whose light is chosen with this probability."""
    particle = Particle()
    radius = table.radius[0]
    disk = place.point * radius
    particle.origin = orthonormal(light.direction) * wp.vec3(disk[0], disk[1], -FAR)
    particle.direction = light.direction
    particle.flux = light.intensity * (PI * radius * radius / (probability * place.density))
    return particle


@wp.func
def emit(scene: SceneData, table: LightTable, pick: wp.uint32, on_emitter: Pair, outgoing: Pair) -> Particle:
    """A light particle whose expected flux is the power of the whole scene (H. W. Jensen, Global Illumination using
    Photon Maps, 1996).

    pick, on_emitter, outgoing: samples of the emitter, of the point on it and of the direction.
    """
    choice = choose_emitter(table.all_emitters, pick)
    particle = Particle()
    if is_triangle(table, choice.index):
        face = table.faces[choice.index]
        particle.light = scene.triangle_material[face]
        particle.spread = MATT
        uv = triangle_barycentrics(on_emitter.x, on_emitter.y)
        particle.origin = point_on(scene, face, uv)
        particle.normal = triangle_normal(scene, face)
        power = PI * table.areas[choice.index] / choice.probability
        turn = outgoing.x
        if emits_from_back(scene, face):
            power *= 2.0
            particle.normal = wp.where(turn < 0.5, particle.normal, -particle.normal)
            turn = wp.where(turn < 0.5, 2.0 * turn, 2.0 * turn - 1.0)
        particle.direction = cosine_direction(particle.normal, turn, outgoing.y)
        particle.flux = emitted_at(scene, face, uv[0], uv[1]) * power
        return particle
    if not is_light(table, choice.index):
        particle.light = scene.materials.shape[0]
        particle.spread = FROM_AFAR
        radius = table.radius[0]
        disk = on_disk(on_emitter.x, on_emitter.y) * radius
        particle.direction = -sky_direction(outgoing.x, outgoing.y)
        # Of the sky's own distribution: radiance over density is the same everywhere.
        brightness = scene.sky[0] * (2.0 * PI)
        if scene.has_environment:
            drawn = sample_environment(scene.environment, outgoing)
            particle.direction = -drawn.direction
            brightness = sky_radiance(scene, drawn.direction) / drawn.density
        particle.origin = orthonormal(particle.direction) * wp.vec3(disk[0], disk[1], -FAR)
        particle.flux = brightness * (PI * radius * radius / choice.probability)
        return particle
    number = choice.index - table.triangle_count - table.sky_count
    light = table.lights[number]
    if light.kind == DIRECTIONAL:
        particle = sun_particle(table, light, sun_place(table.suns, number, outgoing, on_emitter), choice.probability)
        particle.light = scene.materials.shape[0] + 1 + number
        return particle
    cos_angle = wp.where(light.kind == SPOT, light.cos_outer, -1.0)
    particle.light = scene.materials.shape[0] + 1 + number
    particle.direction = cone_direction(light.direction, cos_angle, outgoing.x, outgoing.y)
    particle.origin = light.position + particle.direction * POINT_GAP
    share = wp.where(light.kind == SPOT, spot_falloff(light, particle.direction), 1.0)
    particle.flux = light.intensity * (share * 2.0 * PI * (1.0 - cos_angle) / choice.probability)
    return particle

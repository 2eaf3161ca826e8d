"""Which of a sun's light matters: that which arrives where random walks from the cameras go.

Walks visit places about as often as their light reaches the cameras, after some bounces: importance is transported as
light is (P. Christensen, Adjoints and Importance in Rendering, 2003). Bounces lose nothing, so that rooms next door
count, too.
"""

from collections.abc import Hashable
from dataclasses import dataclass

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import closest_hit, occluded, offset_origin
from gpu.device_scene.surface import surface_at
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import CameraData, camera_data, camera_ray
from gpu.lights.light_table import DIRECTIONAL, FAR, LightTable
from gpu.lights.sun_map import SUN_MAP_PARAMETERS, SunMaps, cell_of, no_sun_maps, sun_maps
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction, orthonormal
from gpu.scene.types import LightKind, Scene

# What a vertex that the sun meets head on counts, in whole numbers, whose sums do not depend on their order.
WHOLE = wp.constant(256.0)


@wp.struct
@dataclass
class WalkParameters:
    """walks: from all cameras together, of `length` vertices each; most_lights: so many first lights have maps."""

    walks: int = 32_768
    length: int = 6
    most_lights: int = 4


WALK_PARAMETERS: WalkParameters = parameters(WalkParameters)


@wp.kernel
def sunlit_walk_kernel(first: int, scene: SceneData, table: LightTable, cameras: wp.array[CameraData], length: int,
                       side: int, seen: wp.array2d[int]) -> None:  # fmt: skip
    """One thread a random walk from a camera: counts, in the cells of directional lights' maps, what these light of it.

    seen: (light, cell) of side² cells, in WHOLE units of the cosine.
    """
    walk = first + wp.tid()
    place = sobol_pair(walk, 0, 0)
    ray = camera_ray(cameras[walk % cameras.shape[0]], place.x, place.y)
    origin = ray.origin
    direction = ray.direction
    for vertex in range(length):
        hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        if hit.face == NO_HIT:
            return
        surface = surface_at(scene, hit, direction)
        normal = surface.geometric_normal
        for light in range(seen.shape[0]):
            sun = table.lights[light]
            cosine = -wp.dot(normal, sun.direction)
            if sun.kind == DIRECTIONAL and cosine > 0.0:
                towards = offset_origin(surface.position, normal, -sun.direction)
                if not occluded(scene, towards, -sun.direction, 2.0 * FAR):
                    at = wp.transpose(orthonormal(sun.direction)) * surface.position / table.radius[0]
                    cell = cell_of(wp.vec2(at[0], at[1]), side)
                    wp.atomic_add(seen, light, cell, int(wp.ceil(WHOLE * cosine)))
        bounce = sobol_pair(walk, 1 + vertex, 0)
        direction = cosine_direction(normal, bounce.x, bounce.y)
        origin = offset_origin(surface.position, normal, direction)


def suns_of(scene: Scene, chosen: WalkParameters = WALK_PARAMETERS) -> Hashable:
    """What maps of the lights of `scene` depend on besides its geometry."""
    suns = [one.kind is LightKind.DIRECTIONAL and one.direction for one in scene.lights[: chosen.most_lights]]
    return tuple(suns), any(suns) and tuple(camera.view_key for camera in scene.cameras)


def sun_maps_of(device_scene: DeviceScene, table: LightTable, chosen: WalkParameters = WALK_PARAMETERS) -> SunMaps:
    """Maps of the directional lights among the first of `table`, by what the scene's cameras see; none without them."""
    scene, device = device_scene.scene, device_scene.device
    lights, side = scene.lights[: chosen.most_lights], SUN_MAP_PARAMETERS.side
    if not (scene.cameras and any(light.kind is LightKind.DIRECTIONAL for light in lights)):
        return no_sun_maps(device)
    views = [camera_data(camera, scene.placement, 1.0) for camera in scene.cameras]
    cameras = wp.array(views, dtype=CameraData, device=device)
    seen = wp.zeros((len(lights), side * side), dtype=int, device=device)
    inputs = [device_scene.data, table, cameras, chosen.length, side, seen]
    launch(sunlit_walk_kernel, chosen.walks, inputs, device)
    return sun_maps(seen.numpy().reshape(len(lights), side, side), device)

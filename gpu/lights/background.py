"""What a camera sees behind every surface: a sky of triangles around the scene, or else the sky itself."""

import warp as wp

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import backdrop_hit
from gpu.device_scene.surface import surface_at
from gpu.lights.light_table import sky_radiance


@wp.func
def background(scene: SceneData, origin: wp.vec3, direction: wp.vec3) -> wp.vec3:
    """Radiance that arrives from unit `direction` where a ray meets no surface [W/m²/sr].

    A sky of triangles shows its picture, lit by nothing: what it emits, or its base colour where it is unlit.
    """
    hit = backdrop_hit(scene, origin, direction)
    if hit.face == NO_HIT:
        return sky_radiance(scene, direction)
    return surface_at(scene, hit, direction).emission

"""Random walks from the scene's cameras, which visit places about as often as light from there reaches the cameras.

Importance is transported as light is (P. Christensen, Adjoints and Importance in Rendering, 2003). Bounces lose
nothing, so that rooms next door count, too.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import launch
from gpu.device_scene.bsdf import is_translucent
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import SIDE_PAIR, matt_side
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import CameraData, camera_data, camera_ray
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction


@wp.struct
class WalkVertex:
    """position, in units of the scene; normal: the geometric one on the walk's side, 0 where the walk has ended."""

    position: wp.vec3
    normal: wp.vec3


@made_for("part_glass")
def camera_walk_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def camera_walk_kernel(first: int, scene: SceneData, cameras: wp.array[CameraData],
                           vertices: wp.array2d[WalkVertex]) -> None:  # fmt: skip
        """One thread a random walk from a camera; the numbers of its bounces are Sobol pairs 1 to its length.

        vertices (walk, vertex): zero before.
        """
        scene = specialise(scene)
        walk = first + wp.tid()
        place = sobol_pair(walk, 0, 0)
        ray = camera_ray(cameras[walk % cameras.shape[0]], place.x, place.y)
        origin = ray.origin
        direction = ray.direction
        for vertex in range(vertices.shape[1]):
            hit = closest_hit(scene, origin, direction, RAY_LENGTH)
            if hit.face == NO_HIT:
                return
            surface = met_at(scene, hit, direction)
            side = sobol_pair(walk, SIDE_PAIR + vertex, 0)
            if side.y < surface.glass and not surface.crossed:
                surface.geometric_normal = -surface.geometric_normal
            elif is_translucent(surface):
                surface = matt_side(surface, -direction, 0.0, side.x)
            visited = WalkVertex()
            visited.position = surface.position
            visited.normal = surface.geometric_normal
            vertices[walk, vertex] = visited
            bounce = sobol_pair(walk, 1 + vertex, 0)
            direction = cosine_direction(visited.normal, bounce.x, bounce.y)
            origin = offset_origin(visited.position, visited.normal, direction)

    return camera_walk_kernel


@wp.func
def has_ended(vertex: WalkVertex) -> bool:
    """Whether a walk did not come to this vertex."""
    return wp.length_sq(vertex.normal) == 0.0


def walk_from_cameras(device_scene: DeviceScene, scene: SceneData, walks: int, length: int) -> wp.array:
    """The vertices (walk, vertex) of so many walks from all cameras of `device_scene` together; it must have one."""
    device, placement = device_scene.device, device_scene.scene.placement
    views = [camera_data(camera, placement, 1.0) for camera in device_scene.scene.cameras]
    vertices = wp.zeros((walks, length), dtype=WalkVertex, device=device)
    inputs = [scene, wp.array(views, dtype=CameraData, device=device), vertices]
    launch(camera_walk_kernel(part_glass_of(scene)), walks, inputs, device)
    return vertices

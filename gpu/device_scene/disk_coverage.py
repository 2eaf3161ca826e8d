"""Whether a flat disk around a surface point is surface all over: what area an estimate of density is divided by."""

import warp as wp

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import closest_hit, occluded
from gpu.device_scene.sides import triangle_normal
from gpu.sampling.warps import orthonormal


@wp.func
def surface_goes_on(scene: SceneData, position: wp.vec3, normal: wp.vec3, turn: float, way: float,
                    height: float, normal_threshold: float) -> bool:  # fmt: skip
    """Whether the surface at `position` reaches the place in its plane that is `way` away at an angle of `turn`.

    height: how far off the plane surface still counts; it must not be hidden from above `position`. normal_threshold:
    least cosine of normals that are alike.
    """
    direction = orthonormal(normal) * wp.vec3(wp.cos(turn), wp.sin(turn), 0.0)
    origin = position + normal * height
    if way <= 0.0 or occluded(scene, origin, direction, way):
        return False
    hit = closest_hit(scene, origin + direction * way, -normal, 2.0 * height)
    if hit.face == NO_HIT:
        return False
    return wp.abs(wp.dot(triangle_normal(scene, hit.face), normal)) > normal_threshold

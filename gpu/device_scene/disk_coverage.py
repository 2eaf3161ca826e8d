"""What lies on a flat disk around a surface point: what area an estimate of density is divided by."""

import warp as wp

from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.rays import closest_hit, occluded
from gpu.sampling.warps import orthonormal


@wp.func
def surface_beside(scene: SceneData, position: wp.vec3, normal: wp.vec3, turn: float, way: float,
                   height: float) -> Hit:  # fmt: skip
    """The surface at the place in the plane of `position` that is `way` away at an angle of `turn`; hit.face is NO_HIT
    where there is none, no more than `height` off the plane, or where it is hidden from above `position`.
    """
    direction = orthonormal(normal) * wp.vec3(wp.cos(turn), wp.sin(turn), 0.0)
    origin = position + normal * height
    hit = Hit()
    hit.face = NO_HIT
    if way <= 0.0 or occluded(scene, origin, direction, way):
        return hit
    return closest_hit(scene, origin + direction * way, -normal, 2.0 * height)

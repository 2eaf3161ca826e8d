"""What lies on a flat disk around a surface point: what area an estimate of density is divided by."""

from math import pi, tan

import warp as wp

from gpu.core.constants import TWO_PI
from gpu.core.intrinsics import bits_of_all
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


@wp.func
def crossed(scene: SceneData, position: wp.vec3, normal: wp.vec3, radius: float, height: float, lane: int,
            lanes: int) -> bool:  # fmt: skip
    """Whether something reaches into a disk from outside and stands at least `height` high: it would cross the octagon
    around the disk. Each of the `lanes` (gpu.core.intrinsics) of a disk looks at sides of its own.
    """
    found = int(0)
    frame = orthonormal(normal)
    half = radius * wp.static(tan(pi / 8.0))
    for side in range(lane, 8, lanes):
        angle = TWO_PI * float(side) / 8.0
        out = frame * wp.vec3(wp.cos(angle), wp.sin(angle), 0.0)
        along = frame * wp.vec3(-wp.sin(angle), wp.cos(angle), 0.0)
        if occluded(scene, position + normal * height + out * radius - along * half, along, 2.0 * half):
            found = 1
            break
    return bits_of_all(found, lanes) == 1

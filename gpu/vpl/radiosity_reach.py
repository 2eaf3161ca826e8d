"""Whether what a VPL knows of its surface's radiosity reaches a point: not where a wall on a floor stands between."""

from functools import cache

import warp as wp

from gpu.device_scene.data import SceneData


@cache
def is_apart_of(blocked: wp.Function) -> wp.Function:
    """The function that looks along a surface with `blocked`, one of gpu.device_scene.rays.occluded and
    occluded_solid.
    """

    @wp.func
    def is_apart(scene: SceneData, position: wp.vec3, normal: wp.vec3, distance: float, other: wp.vec3,
                 clearance: float) -> bool:  # fmt: skip
        """Whether something stands between two points of a surface, of which a ray of length `distance` met the first.

        clearance: how far above the surface the way between them is traced, as a share of its length.
        """
        way = other - position
        length = wp.length(way)
        if length == 0.0:
            return False
        lift = normal * wp.min(clearance * length, 0.5 * distance)
        return blocked(scene, position + lift, way / length, length)

    return is_apart

"""Whether what a VPL knows of its surface's radiosity reaches a point: not where a wall on a floor stands between."""

from functools import cache

import warp as wp

from gpu.device_scene.data import SceneData


@cache
def is_apart_of(blocked: wp.Function) -> wp.Function:
    """The function that looks along a surface with `blocked`, gpu.device_scene.rays.occluded or a
    variant of it.
    """

    @wp.func
    def is_apart(scene: SceneData, position: wp.vec3, normal: wp.vec3, seen_from: wp.vec3, other: wp.vec3,
                 clearance: float) -> bool:  # fmt: skip
        """Whether something stands between two points of a surface, of which a ray that began at `seen_from` met the
        first.

        clearance: how far above the surface the way between them is traced, as a share of its length; but no farther
        than half as high as the ray began: a ray along a narrow gap is long, and above it is what bounds the gap.
        """
        way = other - position
        length = wp.length(way)
        if length == 0.0:
            return False
        height = wp.max(wp.dot(seen_from - position, normal), 0.0)
        lift = normal * wp.min(clearance * length, 0.5 * height)
        return blocked(scene, position + lift, way / length, length)

    return is_apart

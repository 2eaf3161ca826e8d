"""Points that are clustered: what k-means knows of shading points and of VPLs alike."""

import warp as wp


@wp.struct
class Points:
    """Surface points to be clustered, in an order that keeps neighbours together.

    position, normal (point,); weight: share in means; spacing: wanted distance of clusters there, unit space;
    count: (1,) how many of the arrays' elements are points.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    weight: wp.array[float]
    spacing: wp.array[float]
    count: wp.array[int]

"""A list of shading points, as kernels take it."""

import warp as wp


@wp.struct
class PointList:
    """Shading points of an image, all or some of them, in Morton order.

    pixels (place,): their pixels; numbers (place,): which of all shading points they are; count (1,): how many there
    are. Places from count[0] on hold nothing.
    """

    pixels: wp.array[int]
    numbers: wp.array[int]
    count: wp.array[int]

"""One number for a colour."""

import warp as wp


@wp.func
def brightness(radiance: wp.vec3) -> float:
    """One number for how bright a radiance is."""
    return (radiance[0] + radiance[1] + radiance[2]) / 3.0

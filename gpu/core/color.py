"""One number for a colour, and colours as luma and chroma."""

import warp as wp


@wp.func
def brightness(radiance: wp.vec3) -> float:
    """One number for how bright a radiance is."""
    return (radiance[0] + radiance[1] + radiance[2]) / 3.0


@wp.func
def to_ycocg(rgb: wp.vec3) -> wp.vec3:
    """Luma, orange and green chroma of a colour: less correlated than its channels (H. Malvar and G. Sullivan 2003)."""
    sides = 0.25 * (rgb[0] + rgb[2])
    return wp.vec3(sides + 0.5 * rgb[1], 0.5 * (rgb[0] - rgb[2]), 0.5 * rgb[1] - sides)


@wp.func
def from_ycocg(colour: wp.vec3) -> wp.vec3:
    """The colour of such luma and chroma."""
    sides = colour[0] - colour[2]
    return wp.vec3(sides + colour[1], colour[0] + colour[2], sides - colour[1])

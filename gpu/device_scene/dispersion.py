"""Dispersion: the index of glass is another for each colour (KHR_materials_dispersion), so a path that meets such glass
goes on in one of them.
"""

import warp as wp

from gpu.device_scene.surface import MIN_IOR, Surface

# Of a path that is of all colours; others are of channel 0, 1 or 2.
ALL_COLOURS = wp.constant(-1)
# Half of what the index differs between red and blue, over what it is more than 1 and over the dispersion, 20 / Abbe
# number: as the extension has it.
HALF_SPREAD = wp.constant(0.025)


@wp.func
def disperses(surface: Surface) -> bool:
    """Whether the chosen part of a surface refracts each colour otherwise."""
    return surface.dispersion > 0.0 and surface.glass > 0.0 and not surface.thin


@wp.func
def drawn_channel(value: float) -> int:
    """One of the three, by a `value` uniform in [0, 1)."""
    return wp.min(int(value * 3.0), 2)


@wp.func
def of_channel(colour: wp.vec3, channel: int) -> wp.vec3:
    """What of light is of one channel, of which one in three is drawn."""
    one = wp.vec3(0.0, 0.0, 0.0)
    one[channel] = 3.0 * colour[channel]
    return one


@wp.func
def refracting(surface: Surface, channel: int) -> Surface:
    """The surface as light of a channel meets it; files may have more dispersion than any index is left by."""
    index = wp.max(surface.eta, 1.0 / surface.eta)
    index = wp.max(index + (index - 1.0) * HALF_SPREAD * surface.dispersion * float(channel - 1), MIN_IOR)
    surface.eta = wp.where(surface.eta > 1.0, index, 1.0 / index)
    return surface

"""Thin films: light that their two faces reflect interferes, so that they have colours (KHR_materials_iridescence).

The extension's approximation of L. Belcour and P. Barla, A Practical Extension to Microfacet Theory for the Modeling of
Varying Iridescence, 2017: Schlick's law at both faces, no polarisation, the spectrum in Fourier space. It is not
inlined: kernels evaluate it in several places.
"""

from math import pi, sqrt

import warp as wp

from gpu.core.constants import PI

# The eye's sensitivities as Gaussians of the phase, x with a second one: pos, √var [1/m] and heights.
POSITION = wp.constant(wp.vec3(1.6810e6, 1.7953e6, 2.2084e6))
VARIANCE = wp.constant(wp.vec3(4.3278e9, 9.3046e9, 6.6121e9))
HEIGHT = wp.constant(
    wp.vec3(
        *(
            height * sqrt(2.0 * pi * variance) / 1.0685e-7
            for height, variance in ((5.4856e-13, 4.3278e9), (4.4201e-13, 9.3046e9), (5.2481e-13, 6.6121e9))
        )
    )
)
RED_POSITION = wp.constant(2.2399e6)
RED_VARIANCE = wp.constant(4.5282e9)
RED_HEIGHT = wp.constant(9.7470e-14 * sqrt(2.0 * pi * 4.5282e9) / 1.0685e-7)
XYZ_TO_RGB = wp.constant(
    wp.mat33(3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560, 0.0556434, -0.2040259, 1.0572252)
)
# A thinner film [nm] fades into what is around it.
THINNEST = wp.constant(0.03)


@wp.func
def schlick_rise(cosine: float) -> float:
    """The share of f90 in Schlick's reflectance."""
    return wp.pow(1.0 - wp.clamp(cosine, 0.0, 1.0), 5.0)


@wp.func
def schlick(f0: float, cosine: float) -> float:
    """Schlick's reflectance with f90 = 1."""
    return f0 + (1.0 - f0) * schlick_rise(cosine)


@wp.func
def normal_reflectance(one: float, other: float) -> float:
    """What a face between these two indices reflects at normal incidence."""
    root = (one - other) / (one + other)
    return root * root


@wp.func
def sensitivity(difference: float, shift: wp.vec3) -> wp.vec3:
    """What a difference between two ways [nm] and a shift of the phase make of white light, as linear RGB."""
    phase = 2.0 * PI * difference * 1.0e-9
    square = phase * phase
    xyz = wp.vec3(
        HEIGHT[0] * wp.cos(POSITION[0] * phase + shift[0]) * wp.exp(-square * VARIANCE[0])
        + RED_HEIGHT * wp.cos(RED_POSITION * phase + shift[0]) * wp.exp(-square * RED_VARIANCE),
        HEIGHT[1] * wp.cos(POSITION[1] * phase + shift[1]) * wp.exp(-square * VARIANCE[1]),
        HEIGHT[2] * wp.cos(POSITION[2] * phase + shift[2]) * wp.exp(-square * VARIANCE[2]),
    )
    return XYZ_TO_RGB * xyz


@wp.func(inline=False)
def film_reflectance(cosine: float, index: float, thickness: float, f0: wp.vec3) -> wp.vec3:
    """What a film of this refractive `index` and `thickness` [nm] in air reflects with what is below, of light that
    meets it at an angle of `cosine`; f0: of what is below, in air.
    """
    white = wp.vec3(1.0, 1.0, 1.0)
    fade = wp.clamp(thickness / THINNEST, 0.0, 1.0)
    film = wp.lerp(1.0, index, fade * fade * (3.0 - 2.0 * fade))
    above = wp.clamp(cosine, 0.0, 1.0)
    square = 1.0 - (1.0 - above * above) / (film * film)
    if square < 0.0:
        return white
    below = wp.sqrt(square)
    upper = schlick(normal_reflectance(film, 1.0), above)
    crosses = 1.0 - upper
    # Faces to what is denser turn the phase round; the upper one does from below.
    turned = wp.where(film < 1.0, 0.0, PI)
    phase = wp.vec3(turned, turned, turned)
    lower = wp.vec3()
    for channel in range(3):
        root = wp.sqrt(wp.clamp(f0[channel], 0.0, 0.9999))
        base = (1.0 + root) / (1.0 - root)
        lower[channel] = schlick(normal_reflectance(base, film), below)
        if base < film:
            phase[channel] = phase[channel] + PI
    both = wp.vec3(
        wp.clamp(upper * lower[0], 1.0e-5, 0.9999),
        wp.clamp(upper * lower[1], 1.0e-5, 0.9999),
        wp.clamp(upper * lower[2], 1.0e-5, 0.9999),
    )
    sent = wp.cw_div(lower * (crosses * crosses), white - both)
    reflected = sent + white * upper
    round_trip = wp.vec3(wp.sqrt(both[0]), wp.sqrt(both[1]), wp.sqrt(both[2]))
    difference = 2.0 * film * thickness * below
    amplitude = wp.cw_mul(sent - white * crosses, round_trip)
    reflected += wp.cw_mul(amplitude, sensitivity(difference, phase) * 2.0)
    amplitude = wp.cw_mul(amplitude, round_trip)
    reflected += wp.cw_mul(amplitude, sensitivity(difference * 2.0, phase * 2.0) * 2.0)
    return wp.min(wp.max(reflected, wp.vec3(0.0, 0.0, 0.0)), white)

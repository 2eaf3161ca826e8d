"""Sheen: upright fibres of cloth, which reflect most at grazing angles (KHR_materials_sheen).

Distribution and masking are those of A. Conty and C. Kulla, Production Friendly Microfacet Sheen BRDF, 2017, as the
extension has them. Where these send back more than arrives, fine fibres seen or lit from along the surface, the lobe is
scaled down to that.
"""

import warp as wp

from gpu.core.constants import TWO_PI

# Fibres of less would be seen along the surface alone, in a rim without width; what is fitted below has no finer ones.
LEAST_ROUGHNESS = wp.constant(0.1)
Powers = wp.types.vector(length=5, dtype=float)
# Of log E, by powers of ∛cos, each by powers of √roughness: least squares of E itself over quadratures, where that is
# below 1, for 29 cosines from 0.001 on and 13 roughnesses from 0.1 on.
FIT_0 = wp.constant(Powers(2.27912, -3.89806, -13.3205, 27.878, -13.3276))
FIT_1 = wp.constant(Powers(7.59909, -26.9763, 86.3934, -106.839, 43.5112))
FIT_2 = wp.constant(Powers(-37.2887, 111.078, -314.266, 393.238, -165.595))
FIT_3 = wp.constant(Powers(-6.69223, 179.237, -250.94, 51.4339, 41.0874))
FIT_4 = wp.constant(Powers(-17.2767, -67.9271, 194.51, -148.491, 32.7742))


@wp.func
def unbounded_reflectance(cosine: float, roughness: float) -> float:
    """E(cosθ, roughness): what white fibres would send back of light from there, which may be more than arrives."""
    root = wp.sqrt(roughness)
    powers = Powers(1.0, root, root * root, root * root * root, root * root * root * root)
    x = wp.pow(wp.clamp(cosine, 1.0e-4, 1.0), 1.0 / 3.0)
    highest = wp.dot(FIT_3, powers) + x * wp.dot(FIT_4, powers)
    lowest = wp.dot(FIT_0, powers) + x * wp.dot(FIT_1, powers)
    return wp.exp(lowest + x * x * (wp.dot(FIT_2, powers) + x * highest))


@wp.func
def sheen_reflectance(cosine: float, roughness: float) -> float:
    """The share of light at an angle of `cosine` that white fibres send back; of light that is even all around, the
    share that they send there. A fit, within 0.012 of the integral of the lobe and 0.002 in the mean.
    """
    return wp.min(unbounded_reflectance(cosine, roughness), 1.0)


@wp.func
def shadowing_exponent(x: float, spread: float) -> float:
    """L(x) of the paper's section 2, between its fits for α = 0 (`spread` 1) and for α = 1 (0)."""
    a = wp.lerp(21.5473, 25.3245, spread)
    b = wp.lerp(3.82987, 3.32435, spread)
    c = wp.lerp(0.19823, 0.16801, spread)
    d = wp.lerp(-1.97760, -1.27393, spread)
    e = wp.lerp(-4.32054, -4.85967, spread)
    return a / (1.0 + b * wp.pow(x, c)) + d * x + e


@wp.func
def fibre_shadowing(cosine: float, alpha: float) -> float:
    """Λ of fibres, by which 1 / (1 + Λ + Λ′) of them are seen and lit."""
    spread = (1.0 - alpha) * (1.0 - alpha)
    if cosine < 0.5:
        return wp.exp(shadowing_exponent(cosine, spread))
    return wp.exp(2.0 * shadowing_exponent(0.5, spread) - shadowing_exponent(1.0 - cosine, spread))


@wp.func
def sheen_lobe(cos_view: float, cos_light: float, cos_half: float, roughness: float) -> float:
    """The lobe of white fibres times the light's cosine; all cosines of the normal, > 0 [1/sr]."""
    alpha = roughness * roughness
    square = wp.clamp(1.0 - cos_half * cos_half, 0.0, 1.0)
    distribution = (2.0 + 1.0 / alpha) * wp.pow(square, 0.5 / alpha) / TWO_PI
    hidden = 1.0 + fibre_shadowing(wp.min(cos_view, 1.0), alpha) + fibre_shadowing(wp.min(cos_light, 1.0), alpha)
    sent = wp.max(unbounded_reflectance(cos_view, roughness), unbounded_reflectance(cos_light, roughness))
    return distribution / (hidden * 4.0 * cos_view * wp.max(sent, 1.0))

"""What a surface reflects of direct light: Lambertian diffuse and glTF's specular lobe (glTF 2.0, appendix B)."""

import warp as wp

from gpu.core.constants import PI, TWO_PI
from gpu.device_scene.surface import Surface
from gpu.sampling.warps import orthonormal

# No real surface reflects less than 2 % at normal incidence; below, the material's specular factor fades the lobe out.
MIN_F0 = wp.constant(0.02)
# Rougher lobes are wide enough for samples of the lights alone.
GLOSSY_ROUGHNESS = wp.constant(0.5)
# A view along the surface divides by zero.
MIN_COSINE = wp.constant(1.0e-4)


@wp.struct
class LobeSample:
    """A direction of the specular lobe and its density [1/sr], zero where it points into the surface."""

    direction: wp.vec3
    density: float


@wp.func
def largest(color: wp.vec3) -> float:
    """The largest channel."""
    return wp.max(color[0], wp.max(color[1], color[2]))


@wp.func
def ggx_distribution(normal: wp.vec3, half: wp.vec3, alpha: float) -> float:
    """Density of microfacet normals at unit `half` (Walter et al., Microfacet Models for Refraction, 2007, Eq. 33)."""
    # 1 − cos² as a cross product, since it would cancel in float32 where the lobe is narrow.
    sine = wp.cross(normal, half)
    cosine = wp.dot(normal, half) * alpha
    share = alpha / (wp.dot(sine, sine) + cosine * cosine)
    return share * share / PI


@wp.func
def specular_density(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """Density [1/sr] that `sample_specular` has in unit direction `light`."""
    alpha = surface.roughness * surface.roughness
    cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
    root = wp.sqrt(alpha * alpha + (1.0 - alpha * alpha) * cos_view * cos_view)
    return 0.5 * ggx_distribution(surface.normal, wp.normalize(view + light), alpha) / (cos_view + root)


@wp.func
def sample_specular(surface: Surface, view: wp.vec3, x: float, y: float) -> LobeSample:
    """`view` mirrored at a microfacet seen from there (J. Dupuy, A. Benyoub, Sampling Visible GGX Normals, 2023)."""
    alpha = surface.roughness * surface.roughness
    frame = orthonormal(surface.normal)
    local = wp.transpose(frame) * view
    local = wp.vec3(local[0], local[1], wp.max(local[2], MIN_COSINE))
    stretched = wp.normalize(wp.vec3(local[0] * alpha, local[1] * alpha, local[2]))
    height = (1.0 - x) * (1.0 + stretched[2]) - stretched[2]
    radius = wp.sqrt(wp.max(1.0 - height * height, 0.0))
    cap = wp.vec3(radius * wp.cos(TWO_PI * y), radius * wp.sin(TWO_PI * y), height) + stretched
    half = frame * wp.normalize(wp.vec3(cap[0] * alpha, cap[1] * alpha, cap[2]))
    sample = LobeSample()
    sample.direction = wp.normalize(half * (2.0 * wp.dot(view, half)) - view)
    if wp.dot(sample.direction, surface.normal) > 0.0:
        sample.density = specular_density(surface, view, sample.direction)
    return sample


@wp.func
def reflected(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """BRDF times the receiver's cosine for unit directions towards viewer and light; zero for light from behind."""
    cos_light = wp.dot(surface.normal, light)
    if cos_light <= 0.0 or wp.dot(surface.geometric_normal, light) <= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    f0 = largest(surface.f0)
    if f0 == 0.0:
        return surface.diffuse * (cos_light / PI)
    half = wp.normalize(view + light)
    f90 = wp.min(f0 / MIN_F0, 1.0)
    rise = wp.pow(1.0 - wp.clamp(wp.dot(view, half), 0.0, 1.0), 5.0)
    fresnel = surface.f0 * (1.0 - rise) + wp.vec3(f90, f90, f90) * rise
    alpha = surface.roughness * surface.roughness
    cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
    # Smith's height-correlated masking and shadowing over 4·cosθ·cosθ′ (Heitz 2014, Eq. 99).
    rest = 1.0 - alpha * alpha
    towards_view = cos_light * wp.sqrt(cos_view * cos_view * rest + alpha * alpha)
    towards_light = cos_view * wp.sqrt(cos_light * cos_light * rest + alpha * alpha)
    specular = 0.5 * ggx_distribution(surface.normal, half, alpha) / (towards_view + towards_light)
    diffuse = wp.cw_mul(wp.vec3(1.0, 1.0, 1.0) - fresnel, surface.diffuse) / PI
    return (diffuse + fresnel * specular) * cos_light

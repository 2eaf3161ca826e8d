"""What glass does with light: sheets and bodies, clear and frosted.

A body (KHR_materials_volume) refracts by its index, a sheet (KHR_materials_transmission alone) lets light through
straight and stands for its two faces and all that happens between them. Both are tinted by the base colour where light
goes through. Frosted glass has GGX microfacets (Walter et al., Microfacet Models for Refraction through Rough Surfaces,
2007) with the masking of the BRDF. A thin film gives colours to what is reflected, and takes as much of all colours
from what goes through as of the brightest. Radiance that enters a denser body grows with the square of its index.
"""

import warp as wp

from gpu.device_scene.bsdf import BsdfSample, facet_density, largest, sample_specular, specular_lobe
from gpu.device_scene.surface import Surface
from gpu.device_scene.thin_film import film_reflectance
from gpu.sampling.sobol import BELOW_ONE


@wp.func
def dielectric_fresnel(cosine: float, eta: float) -> float:
    """Unpolarised reflectance of a face whose far side has `eta` times the index, met at an angle of `cosine` >= 0."""
    square = 1.0 - (1.0 - cosine * cosine) / (eta * eta)
    if square <= 0.0:
        return 1.0
    inner = wp.sqrt(square)
    parallel = (eta * cosine - inner) / (eta * cosine + inner)
    crossed = (cosine - eta * inner) / (cosine + eta * inner)
    return 0.5 * (parallel * parallel + crossed * crossed)


@wp.func
def sheet_fresnel(cosine: float, eta: float) -> float:
    """What a sheet of index `eta` reflects, between its faces any number of times: 2R / (1 + R)."""
    one = dielectric_fresnel(cosine, eta)
    return 2.0 * one / (1.0 + one)


@wp.func
def attenuated(absorption: wp.vec3, length: float) -> wp.vec3:
    """What is left of light after `length` in a body that absorbs [1/unit length] (Beer's law)."""
    if largest(absorption) <= 0.0:
        return wp.vec3(1.0, 1.0, 1.0)
    depth = absorption * length
    return wp.vec3(wp.exp(-depth[0]), wp.exp(-depth[1]), wp.exp(-depth[2]))


@wp.func
def film_on_glass(surface: Surface, cosine: float, plain: float) -> wp.vec3:
    """What glass with a thin film reflects at an angle of `cosine` >= 0, without it `plain`."""
    outside = cosine
    if surface.eta < 1.0:
        # From inside a body a film reflects as from outside at the angle of refraction.
        outside = wp.sqrt(wp.max(1.0 - (1.0 - cosine * cosine) / (surface.eta * surface.eta), 0.0))
    film = film_reflectance(outside, surface.film_ior, surface.film_thickness, surface.film_f0)
    if surface.thin:
        film = wp.cw_div(film * 2.0, wp.vec3(1.0, 1.0, 1.0) + film)
    return wp.lerp(wp.vec3(plain, plain, plain), film, surface.film)


@wp.func
def plain_fresnel(surface: Surface, cosine: float) -> float:
    """What the glass of `surface` reflects at an angle of `cosine`, without a thin film."""
    if surface.thin:
        return sheet_fresnel(wp.min(wp.abs(cosine), 1.0), surface.eta)
    return dielectric_fresnel(wp.min(wp.abs(cosine), 1.0), surface.eta)


@wp.func
def glass_fresnel(surface: Surface, cosine: float) -> float:
    """What the glass of `surface` reflects at an angle of `cosine`; of the colours of a thin film, the most."""
    if surface.crossed:
        return 1.0
    plain = plain_fresnel(surface, cosine)
    if surface.film > 0.0:
        return largest(film_on_glass(surface, wp.min(wp.abs(cosine), 1.0), plain))
    return plain


@wp.func
def reflected_colour(surface: Surface, cosine: float) -> wp.vec3:
    """The colour of what glass reflects at an angle of `cosine`, over `glass_fresnel`: white without a thin film."""
    if surface.film > 0.0:
        film = film_on_glass(surface, wp.min(wp.abs(cosine), 1.0), plain_fresnel(surface, cosine))
        return film / wp.max(largest(film), 1.0e-6)
    return wp.vec3(1.0, 1.0, 1.0)


@wp.func
def refracted(surface: Surface, view: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """The unit direction in which what reaches `view` through a body's facet of unit `normal` meets it from behind."""
    cosine = wp.dot(view, normal)
    square = 1.0 - (1.0 - cosine * cosine) / (surface.eta * surface.eta)
    return wp.normalize(normal * (cosine / surface.eta - wp.sqrt(wp.max(square, 0.0))) - view / surface.eta)


@wp.func
def mirrored(surface: Surface, direction: wp.vec3) -> wp.vec3:
    """`direction` mirrored to the other side of the surface."""
    return direction - surface.normal * (2.0 * wp.dot(surface.normal, direction))


@wp.func
def facet_of(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """The unit normal, on the viewer's side, of facets that send light from unit `light` to unit `view`."""
    half = view + light
    if wp.dot(surface.normal, light) < 0.0:
        half = view + light * surface.eta
        if surface.thin:
            half = view + mirrored(surface, light)
    half = wp.normalize(half)
    return wp.where(wp.dot(half, surface.normal) < 0.0, -half, half)


@wp.func
def refraction_jacobian(surface: Surface, view: wp.vec3, light: wp.vec3, facet: wp.vec3) -> float:
    """Solid angle of facets per solid angle of light that a body refracts (Walter et al. 2007, Eq. 17)."""
    crossing = wp.dot(light, facet) + wp.dot(view, facet) / surface.eta
    return wp.abs(wp.dot(light, facet)) / (crossing * crossing)


@wp.func
def is_on_its_side(surface: Surface, light: wp.vec3) -> bool:
    """Whether both normals agree on which side of the surface `light` is."""
    return wp.dot(surface.normal, light) * wp.dot(surface.geometric_normal, light) > 0.0


@wp.func
def glass_density(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """Density [1/sr] that `sample_glass` has in unit direction `light`; 0 for clear glass, which has none."""
    if surface.clear or not is_on_its_side(surface, light):
        return 0.0
    facet = facet_of(surface, view, light)
    cosine = wp.dot(view, facet)
    reflects = glass_fresnel(surface, cosine)
    facets = facet_density(surface, view, facet)
    if wp.dot(surface.normal, light) > 0.0:
        return reflects * facets
    if surface.thin:
        return (1.0 - reflects) * facets
    if cosine <= 0.0 or wp.dot(light, facet) >= 0.0:
        return 0.0
    return (1.0 - reflects) * facets * 4.0 * cosine * refraction_jacobian(surface, view, light, facet)


@wp.func
def glass_value(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """BSDF of frosted glass times the light's cosine for unit directions towards viewer and light; 0 for clear one."""
    if surface.clear or not is_on_its_side(surface, light):
        return wp.vec3(0.0, 0.0, 0.0)
    facet = facet_of(surface, view, light)
    cosine = wp.dot(view, facet)
    reflects = glass_fresnel(surface, cosine)
    lobe = specular_lobe(surface, view, light, facet) * wp.abs(wp.dot(surface.normal, light))
    if wp.dot(surface.normal, light) > 0.0:
        return reflected_colour(surface, cosine) * (reflects * lobe)
    if surface.thin:
        return surface.albedo * ((1.0 - reflects) * lobe)
    if cosine <= 0.0 or wp.dot(light, facet) >= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    jacobian = refraction_jacobian(surface, view, light, facet)
    return surface.albedo * ((1.0 - reflects) * lobe * 4.0 * cosine * jacobian / (surface.eta * surface.eta))


@wp.func
def sample_glass(surface: Surface, view: wp.vec3, choice: float, x: float, y: float) -> BsdfSample:
    """A direction that glass sends light from to unit `view`; choice: of the side. All three uniform in [0, 1)."""
    sample = BsdfSample()
    facet = surface.normal
    if not surface.clear:
        facet = wp.normalize(view + sample_specular(surface, view, x, y).direction)
    reflects = glass_fresnel(surface, wp.dot(view, facet))
    light = facet * (2.0 * wp.dot(view, facet)) - view
    crosses = choice >= reflects
    if crosses:
        light = mirrored(surface, light) if surface.thin else refracted(surface, view, facet)
    sample.direction = light
    if not is_on_its_side(surface, light) or (wp.dot(surface.normal, light) < 0.0) != crosses:
        return sample
    if surface.clear:
        sample.weight = reflected_colour(surface, wp.dot(view, facet))
        if crosses:
            sample.weight = surface.albedo
            if not surface.thin:
                sample.weight = surface.albedo / (surface.eta * surface.eta)
        return sample
    sample.density = glass_density(surface, view, light)
    if sample.density > 0.0:
        sample.weight = glass_value(surface, view, light) / sample.density
    return sample


@wp.func
def side_share(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """The share of the light that glass sends to `view` from the side that unit `light` is on."""
    reflects = glass_fresnel(surface, wp.dot(view, facet_of(surface, view, light)))
    return wp.where(wp.dot(surface.normal, light) > 0.0, reflects, 1.0 - reflects)


@wp.func
def sample_side(surface: Surface, view: wp.vec3, side: int, x: float, y: float) -> BsdfSample:
    """A direction on one side of glass, the viewer's (0) or the other (1), and what light from there counts when both
    sides have a sample; x, y: uniform in [0, 1).
    """
    sample = sample_glass(surface, view, float(side) * BELOW_ONE, x, y)
    crosses = wp.dot(surface.normal, sample.direction) < 0.0
    if crosses != (side == 1):
        return BsdfSample()  # all is reflected
    share = side_share(surface, view, sample.direction)
    sample.weight = sample.weight * share
    if share > 0.0:
        sample.density = sample.density / share
    return sample

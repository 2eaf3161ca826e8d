"""What a surface scatters: glTF's metallic-roughness BRDF (glTF 2.0, appendix B.3.5), a diffuse and a specular lobe.

Single scattering, as the appendix has it: a white furnace shows that metals lose 12 % at roughness 0.5 and 59 % at 1,
and that the sum of both lobes gains up to 5 % on white dielectrics. The specular lobe is GGX with the height-correlated
masking of Smith and Schlick's Fresnel term between f0 and f90 (KHR_materials_ior, KHR_materials_specular). The diffuse
lobe may scatter a part of the light to the other side (KHR_materials_diffuse_transmission). Cloth has fibres over both
(gpu.device_scene.sheen), which reflect by a lobe of their own and take of what is below. A thin film's reflectance
takes the place of Schlick's (gpu.device_scene.thin_film). Facets may lie along a grain (KHR_materials_anisotropy).
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.constants import PI, TWO_PI
from gpu.device_scene.sheen import sheen_lobe, sheen_reflectance
from gpu.device_scene.surface import Surface, film_fresnel, left_by_sheen
from gpu.sampling.warps import cone_direction, cosine_direction, orthonormal

# A view along the surface divides by zero.
MIN_COSINE = wp.constant(1.0e-4)


@dataclass(frozen=True)
class BsdfParameters:
    """How samples are shared out.

    glossy_roughness: rougher lobes are wide enough for samples of the lights alone, and for indirect light to count as
    even; from traced_roughness on, rays of the lobe count the less for indirect light the nearer it is to that;
    least_share: no lobe of a surface that has several gets fewer of the samples than this, about. faint, strong: lobes
    that reflect no more than `faint` at normal incidence cast no caustics, as all usual dielectrics, those from
    `strong` on all that they can, as metals.
    """

    glossy_roughness: float = 0.5
    traced_roughness: float = 0.4
    least_share: float = 0.1
    faint: float = 0.1
    strong: float = 0.2


BSDF_PARAMETERS = BsdfParameters()


@wp.struct
class LobeSample:
    """A direction of the specular lobe and its density [1/sr], zero where it points into the surface."""

    direction: wp.vec3
    density: float


@wp.struct
class BsdfSample:
    """A direction, what light from there counts: BSDF · cosine / density, zero where there is none, and the density
    [1/sr], zero for a direction that is the only one of its kind.
    """

    direction: wp.vec3
    weight: wp.vec3
    density: float


@wp.func
def is_glossy(surface: Surface) -> bool:
    """Whether the specular lobe needs samples of its own beside those of the lights."""
    return surface.f90 > 0.0 and surface.roughness < wp.static(BSDF_PARAMETERS.glossy_roughness)


@wp.func
def traced_share(roughness: float, f90: float) -> float:
    """The share of the indirect light in a specular lobe that rays of the lobe look for; the rest counts as even."""
    if f90 == 0.0:
        return 0.0
    widest = wp.static(BSDF_PARAMETERS.glossy_roughness)
    fade = wp.static(BSDF_PARAMETERS.glossy_roughness - BSDF_PARAMETERS.traced_roughness)
    return wp.clamp((widest - roughness) / fade, 0.0, 1.0)


@wp.func
def largest(color: wp.vec3) -> float:
    """The largest channel."""
    return wp.max(color[0], wp.max(color[1], color[2]))


@wp.func
def is_translucent(surface: Surface) -> bool:
    """Whether it scatters light to its other side."""
    return largest(surface.through) > 0.0


@wp.func
def side_towards(surface: Surface, direction: wp.vec3) -> wp.vec3:
    """The geometric normal of the side that unit `direction` is on, of a surface that scatters light from there."""
    if is_translucent(surface) and wp.dot(surface.geometric_normal, direction) < 0.0:
        return -surface.geometric_normal
    return surface.geometric_normal


@wp.func
def all_diffuse(surface: Surface) -> wp.vec3:
    """Reflectance of the diffuse lobe for light from both sides."""
    if is_translucent(surface):
        return surface.diffuse + surface.through
    return surface.diffuse


@wp.func
def through_share(surface: Surface) -> float:
    """The part of the samples of the diffuse lobe that go to the other side."""
    if not is_translucent(surface):
        return 0.0
    through = largest(surface.through)
    return through / (through + largest(surface.diffuse))


@wp.func
def is_followed(surface: Surface) -> bool:
    """Whether frames of a view that rests look along the specular lobe, so that nothing of it counts as even."""
    return surface.f90 > 0.0 and (is_glossy(surface) or largest(all_diffuse(surface)) == 0.0)


@wp.func
def is_grained(surface: Surface) -> bool:
    """Whether its facets lie along a direction, as those of brushed metal."""
    return wp.length_sq(surface.grain) > 0.0


@wp.func
def facet_widths(surface: Surface) -> wp.vec2:
    """α along the grain and across it (KHR_materials_anisotropy)."""
    alpha = surface.roughness * surface.roughness
    return wp.vec2(wp.lerp(alpha, 1.0, wp.min(wp.length(surface.grain), 1.0)), alpha)


@wp.func
def facet_frame(surface: Surface) -> wp.mat33:
    """The grain, what is across it, and the normal, as columns."""
    if is_grained(surface):
        along = wp.normalize(surface.grain)
        return wp.matrix_from_cols(along, wp.cross(surface.normal, along), surface.normal)
    return orthonormal(surface.normal)


@wp.func
def ggx_distribution(surface: Surface, half: wp.vec3) -> float:
    """Density of microfacet normals at unit `half` (Walter et al., Microfacet Models for Refraction, 2007, Eq. 33;
    along a grain Heitz, Understanding the Masking-Shadowing Function, 2014, Eq. 85).
    """
    if is_grained(surface):
        widths = facet_widths(surface)
        local = wp.transpose(facet_frame(surface)) * half
        x = local[0] / widths[0]
        y = local[1] / widths[1]
        square = x * x + y * y + local[2] * local[2]
        return 1.0 / (PI * widths[0] * widths[1] * square * square)
    alpha = surface.roughness * surface.roughness
    # 1 − cos² as a cross product, since it would cancel in float32 where the lobe is narrow.
    sine = wp.cross(surface.normal, half)
    cosine = wp.dot(surface.normal, half) * alpha
    share = alpha / (wp.dot(sine, sine) + cosine * cosine)
    return share * share / PI


@wp.func
def masking_root(surface: Surface, direction: wp.vec3, cosine: float) -> float:
    """The root in Smith's masking of facets from a unit `direction`, at an angle of `cosine` >= 0 to the normal."""
    if is_grained(surface):
        widths = facet_widths(surface)
        local = wp.transpose(facet_frame(surface)) * direction
        x = local[0] * widths[0]
        y = local[1] * widths[1]
        return wp.sqrt(x * x + y * y + cosine * cosine)
    alpha = surface.roughness * surface.roughness
    return wp.sqrt(cosine * cosine * (1.0 - alpha * alpha) + alpha * alpha)


@wp.func
def fresnel(surface: Surface, cosine: float) -> wp.vec3:
    """Reflectance of microfacets that are seen at an angle of `cosine`: Schlick's, or a thin film's."""
    if surface.film > 0.0:
        return film_fresnel(surface, cosine)
    rise = wp.pow(1.0 - wp.clamp(cosine, 0.0, 1.0), 5.0)
    return surface.f0 * (1.0 - rise) + wp.vec3(surface.f90, surface.f90, surface.f90) * rise


@wp.func
def film_veil(reflectance: wp.vec3) -> wp.vec3:
    """What a film with this reflectance keeps from the diffuse lobe, which is grey lest that have inverse colours."""
    most = largest(reflectance)
    return wp.vec3(most, most, most)


@wp.func
def left_by_veil(surface: Surface, view: wp.vec3) -> wp.vec3:
    """What a film that is seen from `view` leaves to the diffuse lobe, over what would be left without its veil."""
    white = wp.vec3(1.0, 1.0, 1.0)
    if surface.film == 0.0:
        return white
    shown = fresnel(surface, wp.dot(surface.normal, view))
    return wp.cw_div(white - film_veil(shown), wp.max(white - shown, white * 1.0e-3))


@wp.func
def specular_lobe(surface: Surface, view: wp.vec3, light: wp.vec3, half: wp.vec3) -> float:
    """Distribution, masking and shadowing of microfacets over 4·cosθ·cosθ′ (Smith's, Heitz 2014, Eq. 99) [1/sr]."""
    cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
    cos_light = wp.abs(wp.dot(surface.normal, light))
    towards_view = cos_light * masking_root(surface, view, cos_view)
    towards_light = cos_view * masking_root(surface, light, cos_light)
    return 0.5 * ggx_distribution(surface, half) / (towards_view + towards_light)


@wp.func
def facet_density(surface: Surface, view: wp.vec3, half: wp.vec3) -> float:
    """Density [1/sr] of the facets that `view` sees at unit normal `half`, over 4 times the cosine between both: that
    of the directions which they mirror to it.
    """
    cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
    return 0.5 * ggx_distribution(surface, half) / (cos_view + masking_root(surface, view, cos_view))


@wp.func
def specular_density(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """Density [1/sr] that `sample_specular` has in unit direction `light` above the surface."""
    return facet_density(surface, view, wp.normalize(view + light))


@wp.func
def sample_specular(surface: Surface, view: wp.vec3, x: float, y: float) -> LobeSample:
    """`view` mirrored at a microfacet seen from there (J. Dupuy, A. Benyoub, Sampling Visible GGX Normals, 2023)."""
    widths = facet_widths(surface)
    frame = facet_frame(surface)
    local = wp.transpose(frame) * view
    local = wp.vec3(local[0], local[1], wp.max(local[2], MIN_COSINE))
    stretched = wp.normalize(wp.vec3(local[0] * widths[0], local[1] * widths[1], local[2]))
    height = (1.0 - x) * (1.0 + stretched[2]) - stretched[2]
    radius = wp.sqrt(wp.max(1.0 - height * height, 0.0))
    cap = wp.vec3(radius * wp.cos(TWO_PI * y), radius * wp.sin(TWO_PI * y), height) + stretched
    half = frame * wp.normalize(wp.vec3(cap[0] * widths[0], cap[1] * widths[1], cap[2]))
    sample = LobeSample()
    sample.direction = wp.normalize(half * (2.0 * wp.dot(view, half)) - view)
    if wp.dot(sample.direction, surface.normal) > 0.0:
        sample.density = specular_density(surface, view, sample.direction)
    return sample


@wp.func
def is_fibrous(surface: Surface) -> bool:
    """Whether there is sheen."""
    return largest(surface.sheen) > 0.0


@wp.func
def left_on_way(surface: Surface, cos_view: float, cos_light: float) -> float:
    """What fibres leave of what is reflected below them, over what they leave on the way to the viewer: less where they
    leave less on the way from the light.
    """
    seen = wp.max(left_by_sheen(surface, cos_view), 1.0e-6)
    return wp.min(left_by_sheen(surface, cos_light) / seen, 1.0)


@wp.func
def sample_lobe(surface: Surface, view: wp.vec3, x: float, y: float) -> BsdfSample:
    """A direction of the specular lobe alone, and what light from there counts in it."""
    sample = BsdfSample()
    lobe = sample_specular(surface, view, x, y)
    sample.direction = lobe.direction
    if lobe.density > 0.0 and wp.dot(lobe.direction, surface.geometric_normal) > 0.0:
        half = wp.normalize(view + lobe.direction)
        cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
        cos_light = wp.dot(surface.normal, lobe.direction)
        share = specular_lobe(surface, view, lobe.direction, half) * cos_light / lobe.density
        if is_fibrous(surface):
            share *= left_on_way(surface, cos_view, cos_light)
        sample.weight = fresnel(surface, wp.dot(view, half)) * share
        sample.density = lobe.density
    return sample


@wp.func
def left_to_diffuse(surface: Surface, view: wp.vec3, reflectance: wp.vec3) -> wp.vec3:
    """What facets with this reflectance leave to the diffuse lobe."""
    cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
    kept = reflectance
    if is_fibrous(surface):
        kept = kept / wp.max(left_by_sheen(surface, cos_view), 1.0e-6)  # what fibres take was there below them
    if surface.film > 0.0:
        kept = film_veil(kept)
    return wp.vec3(1.0, 1.0, 1.0) - kept


@wp.func
def scattered_through(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """`reflected` for light from behind: facets keep what they do of its mirror image."""
    cos_light = -wp.dot(surface.normal, light)
    if cos_light <= 0.0 or wp.dot(surface.geometric_normal, light) >= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    value = surface.through * (cos_light / PI)
    if surface.f90 > 0.0:
        half = wp.normalize(view + light + surface.normal * (2.0 * cos_light))
        value = wp.cw_mul(value, left_to_diffuse(surface, view, fresnel(surface, wp.dot(view, half))))
    if is_fibrous(surface):
        value = value * left_on_way(surface, wp.max(wp.dot(surface.normal, view), MIN_COSINE), cos_light)
    return value


@wp.func
def reflected_below(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """`reflected` without fibres on the way from the light, and from the viewer's side alone."""
    cos_light = wp.dot(surface.normal, light)
    if cos_light <= 0.0 or wp.dot(surface.geometric_normal, light) <= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    if surface.f90 == 0.0:
        return surface.diffuse * (cos_light / PI)
    half = wp.normalize(view + light)
    reflectance = fresnel(surface, wp.dot(view, half))
    diffuse = wp.cw_mul(left_to_diffuse(surface, view, reflectance), surface.diffuse) / PI
    return (diffuse + reflectance * specular_lobe(surface, view, light, half)) * cos_light


@wp.func
def reflected(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """BSDF times the receiver's cosine for unit directions towards viewer and light; zero for light from behind, but
    for what scatters it through.
    """
    if is_translucent(surface) and wp.dot(surface.normal, light) < 0.0:
        return scattered_through(surface, view, light)
    value = reflected_below(surface, view, light)
    if is_fibrous(surface):
        cos_light = wp.dot(surface.normal, light)
        if cos_light > 0.0 and wp.dot(surface.geometric_normal, light) > 0.0:
            cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
            cos_half = wp.dot(surface.normal, wp.normalize(view + light))
            value = value * left_on_way(surface, cos_view, cos_light)
            if surface.sheen_roughness > 0.0:
                lobe = sheen_lobe(cos_view, cos_light, cos_half, surface.sheen_roughness)
                value += surface.sheen * lobe
    return value


@wp.func
def even_sheen(surface: Surface, view: wp.vec3) -> wp.vec3:
    """The part of `even_reflectance` that fibres have."""
    if surface.sheen_roughness <= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    return surface.sheen * sheen_reflectance(wp.dot(surface.normal, view), surface.sheen_roughness)


@wp.func
def specular_share(surface: Surface, view: wp.vec3) -> float:
    """Probability with which `sample_brdf` takes the specular lobe: its part of what is reflected to `view`, about."""
    if surface.f90 == 0.0:
        return 0.0
    diffuse = all_diffuse(surface)
    matt = diffuse[0] + diffuse[1] + diffuse[2]
    if is_fibrous(surface):
        sheen = even_sheen(surface, view)
        matt += sheen[0] + sheen[1] + sheen[2]
    if matt == 0.0:
        return 1.0
    shown = fresnel(surface, wp.dot(surface.normal, view))
    glossy = shown[0] + shown[1] + shown[2]
    least = wp.static(BSDF_PARAMETERS.least_share)
    return wp.clamp(glossy / (glossy + matt * (1.0 - glossy / 3.0)), least, 1.0 - least)


@wp.func
def sheen_share(surface: Surface, view: wp.vec3) -> float:
    """The part of the samples of no specular lobe that go evenly everywhere, for sheen."""
    matt = largest(all_diffuse(surface))
    if matt == 0.0:
        return 1.0
    fibres = largest(even_sheen(surface, view))
    least = wp.static(BSDF_PARAMETERS.least_share)
    return wp.clamp(fibres / (fibres + matt), least, 1.0 - least)


@wp.func
def is_behind(surface: Surface, light: wp.vec3) -> bool:
    """Whether unit `light` is on the other side of a translucent surface, where no lobe but the diffuse one goes."""
    return is_translucent(surface) and wp.dot(surface.normal, light) <= 0.0


@wp.func
def brdf_density(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """Density [1/sr] that `sample_brdf` has in unit direction `light`."""
    share = specular_share(surface, view)
    density = (1.0 - share) * wp.max(wp.dot(surface.normal, light), 0.0) / PI
    if is_translucent(surface):
        through = through_share(surface)
        cosine = wp.dot(surface.normal, light)
        density = (1.0 - share) * wp.where(cosine > 0.0, 1.0 - through, through) * wp.abs(cosine) / PI
    if is_fibrous(surface):
        even = sheen_share(surface, view)
        density = density * (1.0 - even)
        if wp.dot(surface.normal, light) > 0.0:
            density += (1.0 - share) * even / TWO_PI
    if share > 0.0 and not is_behind(surface, light):
        density += share * specular_density(surface, view, light)
    return density


@wp.func
def goes_through(surface: Surface, view: wp.vec3, choice: float, share: float) -> bool:
    """Whether `choice` takes the other side of a translucent surface whose specular lobe has this share of samples."""
    diffuse = 1.0 - share
    if is_fibrous(surface):
        diffuse = diffuse * (1.0 - sheen_share(surface, view))
    return 1.0 - choice <= diffuse * through_share(surface)


@wp.func
def sample_brdf(surface: Surface, view: wp.vec3, choice: float, x: float, y: float) -> BsdfSample:
    """A direction that `surface` reflects to unit `view` from; choice: of the lobe, all three uniform in [0, 1)."""
    sample = BsdfSample()
    if surface.mirror:
        sample.direction = surface.normal * (2.0 * wp.dot(surface.normal, view)) - view
        if wp.dot(sample.direction, surface.geometric_normal) > 0.0:
            sample.weight = fresnel(surface, wp.dot(surface.normal, view))
        return sample
    share = specular_share(surface, view)
    if choice < share:
        sample.direction = sample_specular(surface, view, x, y).direction
        if is_behind(surface, sample.direction):
            return sample
    elif is_fibrous(surface) and choice - share < (1.0 - share) * sheen_share(surface, view):
        sample.direction = cone_direction(surface.normal, 0.0, x, y)
    elif is_translucent(surface) and goes_through(surface, view, choice, share):
        sample.direction = cosine_direction(-surface.normal, x, y)
    else:
        sample.direction = cosine_direction(surface.normal, x, y)
    value = reflected(surface, view, sample.direction)
    if largest(value) > 0.0:
        sample.density = brdf_density(surface, view, sample.direction)
        sample.weight = value / sample.density
    return sample

"""What a surface reflects of light that comes evenly from all around, as methods take indirect light."""

import warp as wp

from gpu.core.constants import PI
from gpu.device_scene.bsdf import (
    BSDF_PARAMETERS,
    MIN_COSINE,
    all_diffuse,
    even_sheen,
    facet_widths,
    is_fibrous,
    is_grained,
    is_translucent,
    largest,
    left_by_veil,
    left_on_way,
    reflected,
    traced_share,
)
from gpu.device_scene.surface import Surface

# Sequences of samples by which sides of what is translucent are chosen, one a vertex: beside all others.
SIDE_PAIR = wp.constant(512)
# Between the normal and light of which fibres leave what they do in the mean of what comes evenly: within 0.005 over
# all views, colours and roughnesses, and 0.04 at most.
FIBRE_COSINE = wp.constant(0.55)
# Of even light, by which is divided.
LEAST_REFLECTED = wp.constant(wp.vec3(1.0e-6, 1.0e-6, 1.0e-6))


@wp.func
def left_evenly(surface: Surface) -> wp.vec3:
    """What facets leave of the light that comes evenly: they keep what they reflect, 0.0037 of it by f90, in the mean
    over views.
    """
    grazing = wp.vec3(surface.f90, surface.f90, surface.f90)
    return wp.vec3(1.0, 1.0, 1.0) - surface.f0 - (grazing - surface.f0) * 0.0037


@wp.func
def left_by_fibres(surface: Surface, view: wp.vec3) -> float:
    """What fibres leave to what is below them of the light that comes evenly, over what they leave on the way to unit
    `view`.
    """
    if not is_fibrous(surface):
        return 1.0
    return left_on_way(surface, wp.max(wp.dot(surface.normal, view), MIN_COSINE), FIBRE_COSINE)


@wp.func
def even_diffuse(surface: Surface) -> wp.vec3:
    """The part of `even_reflectance` that the diffuse lobe has, of a surface with a specular one, below any fibres."""
    return wp.cw_mul(all_diffuse(surface), left_evenly(surface))


@wp.func
def even_through(surface: Surface, view: wp.vec3) -> wp.vec3:
    """The part of `even_reflectance` that is of light from behind."""
    return wp.cw_mul(surface.through, left_evenly(surface)) * left_by_fibres(surface, view)


@wp.func
def with_mirror(surface: Surface, even: wp.vec3) -> wp.vec3:
    """What a sheet of glass in part that is not crossed reflects of even light, `even` by the rest of it."""
    return wp.lerp(even, wp.vec3(1.0, 1.0, 1.0), surface.glass)


@wp.func
def even_matt(surface: Surface, view: wp.vec3) -> wp.vec3:
    """The part of `even_reflectance` that all but the specular lobe has, of a surface with one."""
    matt = even_diffuse(surface)
    if is_fibrous(surface):
        matt = matt * left_by_fibres(surface, view) + even_sheen(surface, view)
    if surface.crossed:
        matt = with_mirror(surface, matt)
    return matt


@wp.func
def even_below(surface: Surface, view: wp.vec3) -> wp.vec3:
    """What `even_reflectance` is below fibres, of which these leave a part."""
    if surface.f90 == 0.0:
        if is_fibrous(surface) or is_translucent(surface):
            return all_diffuse(surface)
        return surface.albedo
    cosine = wp.clamp(wp.dot(surface.normal, view), 0.0, 1.0)
    rough = surface.roughness
    if is_grained(surface):
        widths = facet_widths(surface)
        rough = wp.sqrt(wp.sqrt(0.5 * wp.length_sq(widths)))  # within 0.04 of what such lobes reflect
    squared = rough * rough
    lost = 0.067 + 1.238 * rough - 1.231 * squared + (1.257 * rough - 0.051 - 0.576 * cosine) * cosine
    whole = 1.0 - squared * lost
    steepness = 5.18 / (1.0 + 0.9 * rough + 0.81 * squared)
    rise = wp.pow(1.0 - cosine, steepness) / (1.0 + 9.7 * squared + 51.8 * squared * squared * rough)
    grazing = wp.vec3(surface.f90, surface.f90, surface.f90)
    return even_diffuse(surface) + surface.f0 * (whole - rise) + grazing * rise


@wp.func
def even_reflectance(surface: Surface, view: wp.vec3) -> wp.vec3:
    """The share of light that comes evenly from all around which `surface` reflects to unit `view`; also the share of
    light from there that it reflects at all. Its base colour where it has no specular lobe and no sheen. What is
    translucent is lit from both sides.

    For methods that take indirect light as even. The lobe's is a fit to integrals of `reflected`, within 0.015 of them
    in the mean and 0.1 at most: what it reflects at f0 = f90 = 1, and the part of this that is by f90. Over all views,
    by their cosine, it is within 0.002: light between surfaces is reflected again and again, and in a white room a
    hundredth too little at each is a twentieth. Below fibres it is within 0.04.
    """
    even = even_below(surface, view)
    if is_fibrous(surface):
        even = even * left_by_fibres(surface, view) + even_sheen(surface, view)
    if surface.crossed:
        even = with_mirror(surface, even)
    return even


@wp.func
def over_even(surface: Surface, view: wp.vec3, light: wp.vec3, even: wp.vec3) -> wp.vec3:
    """What `surface` reflects of light from unit `light` to unit `view`, over what it would if it reflected `even` of
    all light evenly.
    """
    cosine = wp.max(wp.dot(surface.normal, light), MIN_COSINE)
    return wp.cw_div(reflected(surface, view, light) * (PI / cosine), wp.max(even, LEAST_REFLECTED))


@wp.func
def focused_share(surface: Surface) -> float:
    """The share of what the specular lobe sends, of light that caustics bring, which is of caustics again."""
    span = wp.static(BSDF_PARAMETERS.strong - BSDF_PARAMETERS.faint)
    strong = wp.clamp((largest(surface.f0) - wp.static(BSDF_PARAMETERS.faint)) / span, 0.0, 1.0)
    return traced_share(surface.roughness, surface.f90) * wp.where(surface.mirror, 1.0, strong)


@wp.func
def spread_reflectance(surface: Surface, view: wp.vec3, focused: float) -> wp.vec3:
    """The part of `even_reflectance` that VPLs send, as if the surface were matt: caustics have the rest of its lobe.

    focused: the share of the light that caustics have brought here, 1 straight from emitters, 0 from matt surfaces.
    """
    even = even_reflectance(surface, view)
    share = focused * focused_share(surface)
    if share > 0.0:
        even -= (even - even_matt(surface, view)) * share
    if surface.crossed:
        even -= wp.vec3(1.0, 1.0, 1.0) * (surface.glass * focused)
    return even


@wp.func
def turned(surface: Surface, view: wp.vec3) -> Surface:
    """The other side of a translucent surface, as matt as light goes through to unit `view`."""
    other = Surface()
    other.position = surface.position
    other.geometric_normal = -surface.geometric_normal
    other.normal = -surface.normal
    other.diffuse = wp.cw_mul(even_through(surface, view), left_by_veil(surface, view))
    other.albedo = other.diffuse
    other.roughness = 1.0
    return other


@wp.func
def matt_side(surface: Surface, view: wp.vec3, focused: float, choice: float) -> Surface:
    """The side from which a translucent surface sends light on, or is lit, where it is taken to be matt: by `choice`,
    uniform in [0, 1), of both by how much light they send to unit `view`, or from there. The less often a side is
    chosen, the more it reflects.

    focused: as of `spread_reflectance`.
    """
    other = turned(surface, view)
    front = spread_reflectance(surface, view, focused) - even_through(surface, view)
    share = largest(other.diffuse) / (largest(other.diffuse) + largest(front))
    side = other
    side.diffuse = other.diffuse / share
    if choice >= share:
        side.geometric_normal = surface.geometric_normal
        side.diffuse = front / (1.0 - share)
    side.normal = side.geometric_normal
    side.albedo = side.diffuse
    return side

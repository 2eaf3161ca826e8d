"""All that a surface does with light: a coat reflects some, of the rest a share meets glass, and the rest of that
reflects, with its sheen, or scatters to its other side. A path takes one of these.
"""

import warp as wp

from gpu.device_scene.bsdf import BsdfSample, brdf_density, is_glossy, reflected, sample_brdf, traced_share
from gpu.device_scene.even_light import focused_share
from gpu.device_scene.glass import glass_density, glass_value, sample_glass
from gpu.device_scene.surface import Surface

# What a clear coat reflects at normal incidence (KHR_materials_clearcoat: its index is 1.5).
COAT_F0 = wp.constant(0.04)


@wp.struct
class PartChoice:
    """The part of a surface that a path takes: its coat, its glass (share 1) or what reflects below (0).

    rest: what is left of the sample that decided it, uniform in [0, 1) again.
    """

    coat: bool
    glass: float
    rest: float


@wp.func
def coat_share(surface: Surface, view: wp.vec3) -> float:
    """What the coat takes of the light that reaches unit `view` (KHR_materials_clearcoat, Layering)."""
    rise = wp.pow(1.0 - wp.clamp(wp.dot(surface.coat_normal, view), 0.0, 1.0), 5.0)
    return surface.coat * (COAT_F0 + (1.0 - COAT_F0) * rise)


@wp.func
def choose_part(surface: Surface, view: wp.vec3, choice: float) -> PartChoice:
    """Which part of `surface` a path takes, by its share; choice: uniform in [0, 1)."""
    chosen = PartChoice()
    chosen.rest = choice
    share = coat_share(surface, view)
    if chosen.rest < share:
        chosen.coat = True
        chosen.rest = chosen.rest / share
        return chosen
    chosen.rest = (chosen.rest - share) / (1.0 - share)
    if chosen.rest < surface.glass:
        chosen.glass = 1.0
        chosen.rest = chosen.rest / surface.glass
    else:
        chosen.rest = (chosen.rest - surface.glass) / (1.0 - surface.glass)
    return chosen


@wp.func
def part_of(surface: Surface, chosen: PartChoice) -> Surface:
    """The chosen part alone, of which a path may choose again."""
    surface.coat = 0.0
    surface.glass = chosen.glass
    if chosen.coat:
        # All that reaches the coat is reflected: how much does, the choice has told.
        surface.diffuse = wp.vec3(0.0, 0.0, 0.0)
        surface.f0 = wp.vec3(1.0, 1.0, 1.0)
        surface.f90 = 1.0
        surface.roughness = surface.coat_roughness
        surface.normal = surface.coat_normal
        surface.mirror = False
        surface.sheen = wp.vec3(0.0, 0.0, 0.0)
        surface.film = 0.0
        surface.grain = wp.vec3(0.0, 0.0, 0.0)
        surface.through = wp.vec3(0.0, 0.0, 0.0)
    return surface


@wp.func
def is_perfect(surface: Surface) -> bool:
    """Whether the chosen part has no lobe, so that light is found by following rays alone."""
    return wp.where(surface.glass > 0.0, surface.clear, surface.mirror)


@wp.func
def is_narrow(surface: Surface) -> bool:
    """Whether the chosen part has a lobe so narrow, or none, that samples of the lights are not enough."""
    return surface.glass > 0.0 or surface.mirror or is_glossy(surface)


@wp.func
def focus_of(surface: Surface) -> float:
    """The share of what the lobe of the chosen part sends, of light that caustics bring, which is of caustics again."""
    if surface.glass > 0.0:
        return traced_share(surface.roughness, 1.0)
    return focused_share(surface)


@wp.func
def scattered(surface: Surface, view: wp.vec3, light: wp.vec3) -> wp.vec3:
    """BSDF of the chosen part times the light's cosine for unit directions to viewer and light; 0 for perfect ones."""
    if surface.glass > 0.0:
        return glass_value(surface, view, light)
    if surface.mirror:
        return wp.vec3(0.0, 0.0, 0.0)
    return reflected(surface, view, light)


@wp.func
def scattering_density(surface: Surface, view: wp.vec3, light: wp.vec3) -> float:
    """Density [1/sr] that `sample_scattering` has in unit direction `light`; 0 for perfect parts."""
    if surface.glass > 0.0:
        return glass_density(surface, view, light)
    if surface.mirror:
        return 0.0
    return brdf_density(surface, view, light)


@wp.func
def sample_scattering(surface: Surface, view: wp.vec3, choice: float, x: float, y: float) -> BsdfSample:
    """A direction that the chosen part sends light from to unit `view`; choice, x, y: uniform in [0, 1)."""
    if surface.glass > 0.0:
        return sample_glass(surface, view, choice, x, y)
    return sample_brdf(surface, view, choice, x, y)

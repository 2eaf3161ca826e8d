"""All that a surface does with light: a share of it is glass, the rest reflects. A path takes one or the other."""

import warp as wp

from gpu.device_scene.bsdf import GLOSSY_ROUGHNESS, BsdfSample, brdf_density, reflected, sample_brdf
from gpu.device_scene.glass import glass_density, glass_value, sample_glass
from gpu.device_scene.surface import Surface


@wp.struct
class LobeChoice:
    """Whether a path takes the glass of a surface (share 1) or what reflects (0), and what is left of the sample that
    decided it, uniform in [0, 1) again.
    """

    glass: float
    rest: float


@wp.func
def choose_lobe(surface: Surface, choice: float) -> LobeChoice:
    """Which part of `surface` a path takes, by its share; choice: uniform in [0, 1)."""
    chosen = LobeChoice()
    if choice < surface.glass:
        chosen.glass = 1.0
        chosen.rest = choice / surface.glass
    else:
        chosen.rest = (choice - surface.glass) / (1.0 - surface.glass)
    return chosen


@wp.func
def is_perfect(surface: Surface) -> bool:
    """Whether the chosen part has no lobe, so that light is found by following rays alone."""
    return wp.where(surface.glass > 0.0, surface.clear, surface.mirror)


@wp.func
def is_narrow(surface: Surface) -> bool:
    """Whether the chosen part has a lobe so narrow, or none, that samples of the lights are not enough."""
    glossy = surface.f90 > 0.0 and surface.roughness < GLOSSY_ROUGHNESS
    return surface.glass > 0.0 or surface.mirror or glossy


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

"""Thin films beside KHR_materials_iridescence's own formulas in float64, and what surfaces have of them."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.device_scene.bsdf import fresnel, left_by_veil, reflected
from gpu.device_scene.glass import glass_fresnel, reflected_colour
from gpu.device_scene.surface import Surface, below_film
from gpu.device_scene.thin_film import film_reflectance
from gpu.scene.types import Doubles

COSINES = np.array([0.05, 0.2, 0.5, 0.8, 1.0])
GOLD = (1.0, 0.77, 0.34)
FILMS = [(1.3, 400.0, (0.04,) * 3), (1.8, 250.0, (0.04,) * 3), (1.33, 600.0, GOLD), (2.0, 1200.0, GOLD)]
XYZ_TO_REC709 = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)


def sensitivity(difference: float, shift: Doubles) -> Doubles:
    """evalSensitivity of the extension."""
    phase = 2.0 * np.pi * difference * 1e-9
    val = np.array([5.4856e-13, 4.4201e-13, 5.2481e-13])
    pos, var = np.array([1.6810e6, 1.7953e6, 2.2084e6]), np.array([4.3278e9, 9.3046e9, 6.6121e9])
    xyz = val * np.sqrt(2.0 * np.pi * var) * np.cos(pos * phase + shift) * np.exp(-(phase**2) * var)
    red = 9.7470e-14 * np.sqrt(2.0 * np.pi * 4.5282e9)
    xyz[0] += red * np.cos(2.2399e6 * phase + shift[0]) * np.exp(-4.5282e9 * phase**2)
    return np.asarray(XYZ_TO_REC709 @ (xyz / 1.0685e-7))


def iridescent_fresnel(cosine: float, index: float, thickness: float, f0: Doubles) -> Doubles:
    """F_iridescence of the extension, in air."""

    def schlick(normal: Doubles, angle: float) -> Doubles:
        return np.asarray(normal + (1.0 - normal) * (1.0 - angle) ** 5)

    below = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    upper = schlick(((index - 1.0) / (index + 1.0)) ** 2, cosine)
    root = np.sqrt(np.clip(f0, 0.0, 0.9999))
    base = (1.0 + root) / (1.0 - root)
    lower = schlick(((base - index) / (base + index)) ** 2, below)
    phase = np.pi + np.where(base < index, np.pi, 0.0)
    both = np.clip(upper * lower, 1e-5, 0.9999)
    sent = (1.0 - upper) ** 2 * lower / (1.0 - both)
    found, amplitude = upper + sent, sent - (1.0 - upper)
    for order in (1, 2):
        amplitude = amplitude * np.sqrt(both)
        difference = 2.0 * index * thickness * below
        found = found + amplitude * 2.0 * sensitivity(order * difference, order * phase)
    return np.clip(found, 0.0, 1.0)


@wp.kernel
def film_kernel(first: int, cosines: wp.array[float], ior: float, thickness: float, f0: wp.vec3,
                out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = film_reflectance(cosines[index], ior, thickness, f0)


@wp.kernel
def seen_kernel(first: int, surface: Surface, views: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:
    """What a surface mirrors to views by its film, and by its f0 in Schlick's law; what is left to its diffuse lobe."""
    index = first + wp.tid()
    view = views[index]
    seen = below_film(surface, view, surface.film, surface.film_ior, surface.film_thickness)
    cosine = wp.dot(surface.normal, view)
    out[3 * index] = fresnel(seen, cosine)
    out[3 * index + 2] = left_by_veil(seen, view)
    seen.film = 0.0
    out[3 * index + 1] = fresnel(seen, cosine)


@wp.kernel
def reflected_kernel(first: int, surface: Surface, view: wp.vec3, light: wp.vec3, out: wp.array[wp.vec3]) -> None:
    out[first + wp.tid()] = reflected(surface, view, light)


@wp.kernel
def glass_kernel(first: int, surface: Surface, cosines: wp.array[float], out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    out[index] = reflected_colour(surface, cosines[index]) * glass_fresnel(surface, cosines[index])


def filmed(f0: tuple[float, float, float], film: float, ior: float, thickness: float, diffuse: float = 0.0) -> Surface:
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(0.0, 0.0, 1.0)
    surface.diffuse, surface.f0, surface.f90, surface.roughness = wp.vec3(diffuse), wp.vec3(*f0), 1.0, 0.3
    surface.film, surface.film_ior, surface.film_thickness = film, ior, thickness
    surface.film_f0 = surface.f0
    return surface


def views(cosines: Doubles) -> wp.array:
    return column([[np.sqrt(1.0 - cosine**2), 0.0, cosine] for cosine in cosines], wp.vec3)


@pytest.mark.parametrize(("ior", "thickness", "f0"), FILMS)
def test_colours_are_the_extensions(ior: float, thickness: float, f0: tuple[float, float, float]) -> None:
    found = results(film_kernel, len(COSINES), [column(COSINES, float), ior, thickness, wp.vec3(*f0)], wp.vec3)
    expected = [iridescent_fresnel(cosine, ior, thickness, np.array(f0)) for cosine in COSINES]
    assert np.allclose(found, expected, atol=2e-3)
    assert np.ptp(found[2:], axis=0).max() > 0.01  # by the angle


def test_a_film_without_thickness_is_not_there() -> None:
    """But that Schlick's law is at two faces, which is seen at grazing angles."""
    found = results(film_kernel, 2, [column(COSINES[3:], float), 1.8, 0.0, wp.vec3(*GOLD)], wp.vec3)
    assert np.allclose(found, GOLD, atol=0.015)


def test_its_f0_has_its_colour_from_where_it_is_seen() -> None:
    """Which methods that know no films show; the diffuse lobe has what the brightest channel leaves."""
    surface = filmed((0.1, 0.1, 0.1), 0.75, 1.8, 250.0, 0.5)
    cosines = COSINES[1:]
    found = results(seen_kernel, len(cosines), [surface, views(cosines)], wp.vec3, width=3)
    film, schlick, left = found[0::3], found[1::3], found[2::3]
    plain = 0.1 + 0.9 * (1.0 - cosines[:, None]) ** 5
    iridescent = [iridescent_fresnel(cosine, 1.8, 250.0, np.full(3, 0.1)) for cosine in cosines]
    assert np.allclose(film, 0.25 * plain + 0.75 * np.array(iridescent), atol=2e-3)
    assert np.allclose(schlick, film, atol=2e-3)
    assert np.allclose((1.0 - schlick) * left, 1.0 - film.max(axis=1, keepdims=True), atol=5e-3)


def test_what_is_below_is_dimmed_without_a_colour() -> None:
    with_film = filmed((0.04, 0.04, 0.04), 1.0, 1.8, 250.0, 0.5)
    view, light = wp.vec3(0.6, 0.0, 0.8), wp.vec3(0.0, 0.0, 1.0)
    cosine = float(np.sqrt((1.0 + 0.8) / 2.0))
    whole = results(reflected_kernel, 1, [with_film, view, light], wp.vec3)[0]
    with_film.diffuse = wp.vec3(0.0)
    lobe = results(reflected_kernel, 1, [with_film, view, light], wp.vec3)[0]
    color = iridescent_fresnel(cosine, 1.8, 250.0, np.full(3, 0.04))
    assert np.allclose(lobe / lobe[0], color / color[0], rtol=0.01)
    assert np.allclose(whole - lobe, 0.5 / np.pi * (1.0 - color.max()), rtol=1e-3)


@pytest.mark.parametrize("thin", [False, True])
def test_glass_reflects_its_colours(thin: bool) -> None:
    surface = filmed((0.04, 0.04, 0.04), 1.0, 1.8, 250.0)
    surface.glass, surface.eta, surface.thin = 1.0, 1.5, thin
    found = results(glass_kernel, len(COSINES), [surface, column(COSINES, float)], wp.vec3)
    one = np.array([iridescent_fresnel(cosine, 1.8, 250.0, np.full(3, 0.04)) for cosine in COSINES])
    assert np.allclose(found, 2.0 * one / (1.0 + one) if thin else one, atol=2e-3)
    if not thin:
        surface.eta = 1.0 / 1.5
        inside = np.sqrt(1.0 - (1.0 - COSINES**2) / 1.5**2)
        from_inside = results(glass_kernel, len(COSINES), [surface, column(inside, float)], wp.vec3)
        assert np.allclose(from_inside, one, atol=3e-3)
        assert np.allclose(results(glass_kernel, 1, [surface, column([0.5], float)], wp.vec3), 1.0, atol=1e-3)

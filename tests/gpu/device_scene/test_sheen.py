"""Sheen beside KHR_materials_sheen's own formulas in float64, its fit beside their integrals, and a white furnace."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.device_scene.bsdf import reflected
from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.sheen import sheen_reflectance
from gpu.device_scene.surface import Surface, below_sheen
from gpu.scene.types import Doubles

POINTS = 128
ROUGHNESS = [0.1, 0.3, 0.6, 1.0]


def shadowing(cosine: Doubles, alpha: float) -> Doubles:
    """lambdaSheen of the extension."""

    def exponent(x: Doubles) -> Doubles:
        t = (1.0 - alpha) ** 2
        a, b = 21.5473 + (25.3245 - 21.5473) * t, 3.82987 + (3.32435 - 3.82987) * t
        c, d = 0.19823 + (0.16801 - 0.19823) * t, -1.97760 + (-1.27393 + 1.97760) * t
        return np.asarray(a / (1.0 + b * x**c) + d * x - 4.32054 + (-4.85967 + 4.32054) * t)

    near, half = exponent(np.minimum(cosine, 0.5)), exponent(np.array(0.5))
    return np.where(cosine < 0.5, np.exp(near), np.exp(2.0 * half - exponent(np.minimum(1.0 - cosine, 0.5))))


def lobe(view: Doubles, lights: Doubles, roughness: float) -> Doubles:
    """The extension's distribution times its visibility; +Z is the normal."""
    alpha = roughness**2
    half = view + lights
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    distribution = (2.0 + 1.0 / alpha) * (1.0 - half[..., 2] ** 2) ** (0.5 / alpha) / (2.0 * np.pi)
    hidden = 1.0 + shadowing(view[2], alpha) + shadowing(lights[..., 2], alpha)
    return np.asarray(distribution / (hidden * 4.0 * view[2] * lights[..., 2]))


def direction(cosine: float, turn: float = 0.0) -> Doubles:
    sine = np.sqrt(1.0 - cosine**2)
    return np.array([sine * np.cos(turn), sine * np.sin(turn), cosine])


def hemisphere() -> tuple[Doubles, Doubles]:
    """Directions (direction, 3), more of them along the surface, and the solid angle of each."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    root, turn = (nodes + 1.0) / 2.0, (nodes + 1.0) * np.pi
    cosine, angle = (grid.ravel() for grid in np.meshgrid(root**2, turn, indexing="ij"))
    sine = np.sqrt(1.0 - cosine**2)
    solid = (root * weights)[:, None] * (weights * np.pi)[None, :]
    return np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], axis=1), solid.ravel()


LIGHTS, SOLID = hemisphere()


def sent_back(cosine: float, roughness: float) -> float:
    """E of the extension, by quadrature."""
    return float((lobe(direction(cosine), LIGHTS, roughness) * LIGHTS[:, 2] * SOLID).sum())


@wp.kernel
def reflected_kernel(first: int, surface: Surface, view: wp.vec3, lights: wp.array[wp.vec3],
                     out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    seen = below_sheen(surface, view, surface.sheen, surface.sheen_roughness)
    out[index] = reflected(seen, view, lights[index])


@wp.kernel
def even_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    seen = below_sheen(surface, view, surface.sheen, surface.sheen_roughness)
    out[first + wp.tid()] = even_reflectance(seen, view)


@wp.kernel
def reflectance_kernel(first: int, cosines: wp.array[float], roughness: float, out: wp.array[float]) -> None:
    index = first + wp.tid()
    out[index] = sheen_reflectance(cosines[index], roughness)


def cloth(roughness: float, color: tuple[float, float, float] = (1.0, 0.5, 0.25), albedo: float = 0.0) -> Surface:
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(0.0, 0.0, 1.0)
    surface.diffuse = wp.vec3(albedo, albedo, albedo)
    surface.sheen, surface.sheen_roughness = wp.vec3(*color), roughness
    return surface


def values(surface: Surface, view: Doubles, lights: Doubles) -> Doubles:
    return results(reflected_kernel, len(lights), [surface, wp.vec3(*view), column(lights, wp.vec3)], wp.vec3)


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_the_lobe_is_the_extensions(roughness: float) -> None:
    view = direction(0.4)
    lights = np.array([direction(cosine, turn) for cosine in (0.1, 0.45, 0.55, 0.95) for turn in (0.2, 2.0, 3.1)])
    expected = lobe(view, lights, roughness)[:, None] * lights[:, 2:] * [1.0, 0.5, 0.25]
    assert np.allclose(values(cloth(roughness), view, lights), expected, rtol=2e-3, atol=1e-6)
    assert not values(cloth(roughness), view, -lights).any()


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_its_integral_is_as_the_fit_says(roughness: float) -> None:
    cosines = np.array([0.003, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0])
    exact = np.minimum([sent_back(cosine, roughness) for cosine in cosines], 1.0)
    fit = results(reflectance_kernel, len(cosines), [column(cosines, float), roughness], float)
    assert np.abs(fit - exact).max() < 0.012


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_what_is_below_has_the_lesser_of_what_both_ways_leave(roughness: float) -> None:
    for seen, lit in ((0.3, 0.8), (0.8, 0.3)):
        view, light = direction(seen), direction(lit, 2.0)
        got = values(cloth(roughness, (0.5, 0.25, 0.0), 0.7), view, light[None])[0]
        left = 1.0 - 0.5 * max(sent_back(seen, roughness), sent_back(lit, roughness))
        expected = lobe(view, light, roughness) * np.array([0.5, 0.25, 0.0]) + 0.7 / np.pi * left
        assert np.allclose(got, expected * lit, atol=0.004)


@pytest.mark.parametrize("cosine", [0.01, 0.15, 0.6, 1.0])
@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_no_light_is_won(roughness: float, cosine: float) -> None:
    view = direction(cosine)
    for color, albedo in ((1.0, 1.0), (0.6, 0.8), (1.0, 0.0)):
        surface = cloth(roughness, (color,) * 3, albedo)
        energy = (values(surface, view, LIGHTS)[:, 0] * SOLID).sum()
        assert energy <= 1.012
        even = results(even_kernel, 1, [surface, wp.vec3(*view)], wp.vec3)[0, 0]
        assert even == pytest.approx(energy, abs=0.04)

"""Fresnel's and Snell's laws; frequencies and energy are in test_scattering.py."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.device_scene.glass import dielectric_fresnel, facet_of, refracted, sheet_fresnel
from gpu.device_scene.surface import Surface
from gpu.scene.types import Doubles

UP = np.array([0.0, 0.0, 1.0])


@wp.kernel
def fresnel_kernel(first: int, cosines: wp.array[float], eta: float, out: wp.array[wp.vec2]) -> None:
    """(reflectance of a face, of a sheet)."""
    index = first + wp.tid()
    cosine = cosines[index]
    out[index] = wp.vec2(dielectric_fresnel(cosine, eta), sheet_fresnel(cosine, eta))


@wp.kernel
def refracted_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """(where the light comes from, the facet that it and `view` tell)."""
    index = first + wp.tid()
    light = refracted(surface, view, surface.normal)
    out[2 * index] = light
    out[2 * index + 1] = facet_of(surface, view, light)


def reflectances(degrees: list[float], eta: float) -> Doubles:
    cosines = np.cos(np.radians(degrees)).astype(np.float32)
    return results(fresnel_kernel, len(cosines), [column(cosines, float), eta], wp.vec2)


@pytest.mark.parametrize("eta", [1.33, 1.5, 2.4, 1.0 / 1.5])
def test_faces_reflect_by_fresnel(eta: float) -> None:
    normal, brewster = reflectances([0.0, float(np.degrees(np.arctan(eta)))], eta)[:, 0]
    assert normal == pytest.approx(((eta - 1.0) / (eta + 1.0)) ** 2, rel=1e-4)
    # At Brewster's angle one of both polarisations is not reflected at all.
    assert brewster == pytest.approx(0.5 * ((1.0 - eta**2) / (1.0 + eta**2)) ** 2, rel=1e-4)


def test_beyond_the_critical_angle_all_is_reflected() -> None:
    critical = float(np.degrees(np.arcsin(1.0 / 1.5)))
    found = reflectances([critical - 1.0, critical + 0.01, 80.0, 90.0], 1.0 / 1.5)[:, 0]
    assert found[0] < 0.6
    assert (found[1:] == 1.0).all()


def test_a_sheet_reflects_what_goes_to_and_fro_in_it() -> None:
    face, sheet = reflectances([40.0], 1.5)[0]
    series = face + sum((1.0 - face) ** 2 * face ** (2 * k + 1) for k in range(20))
    assert sheet == pytest.approx(series, rel=1e-5)


@pytest.mark.parametrize("eta", [1.5, 1.0 / 1.2])
def test_light_is_refracted_by_snell(eta: float) -> None:
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*UP)
    surface.eta = eta
    view = np.array([0.6, 0.0, 0.8])
    light, facet = results(refracted_kernel, 1, [surface, wp.vec3(*view)], wp.vec3, width=2)
    assert np.allclose(light, [-0.6 / eta, 0.0, -np.sqrt(1.0 - (0.6 / eta) ** 2)], atol=1e-6)
    assert np.allclose(facet, UP, atol=1e-5)

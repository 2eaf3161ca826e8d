import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.core.constants import PI
from gpu.device_scene.bsdf import reflected, sample_specular, specular_density
from gpu.device_scene.surface import Surface
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cone_direction
from gpu.scene.types import Doubles

COUNT = 1 << 15
NORMAL = np.array([0.0, 0.6, 0.8])


@wp.kernel
def reflected_kernel(first: int, surface: Surface, view: wp.vec3, lights: wp.array[wp.vec3],
                     out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = reflected(surface, view, lights[index])


@wp.kernel
def albedo_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """Reflected light of a white furnace by a sample of the lobe, (red, whether the sample is above, density ratio)."""
    index = first + wp.tid()
    place = sobol_pair(index, 0, 1)
    sample = sample_specular(surface, view, place.x, place.y)
    if sample.density > 0.0:
        ratio = sample.density / specular_density(surface, view, sample.direction)
        out[index] = wp.vec3(reflected(surface, view, sample.direction)[0] / sample.density, 1.0, ratio)


@wp.kernel
def uniform_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec2]) -> None:
    """(reflected red, density) in uniform directions of the hemisphere, over theirs."""
    index = first + wp.tid()
    place = sobol_pair(index, 0, 2)
    light = cone_direction(surface.normal, 0.0, place.x, place.y)
    value = wp.vec2(reflected(surface, view, light)[0], specular_density(surface, view, light))
    out[index] = value * (2.0 * PI)


def surface_of(diffuse: float, f0: float, roughness: float) -> Surface:
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*NORMAL)
    surface.diffuse, surface.f0 = wp.vec3(diffuse, diffuse, diffuse), wp.vec3(f0, f0, f0)
    surface.roughness = roughness
    return surface


def at_angle(degrees: float, towards: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> Doubles:
    """The unit vector that leans by an angle from the normal."""
    side = np.array(towards) - NORMAL * (NORMAL @ towards)
    side /= np.linalg.norm(side)
    return np.asarray(np.cos(np.radians(degrees)) * NORMAL + np.sin(np.radians(degrees)) * side)


def value(surface: Surface, view: Doubles, light: Doubles) -> Doubles:
    return results(reflected_kernel, 1, [surface, wp.vec3(*view), column([light], wp.vec3)], wp.vec3)[0]


def test_without_a_specular_lobe_it_is_lamberts_law() -> None:
    got = value(surface_of(0.6, 0.0, 1.0), at_angle(30.0), at_angle(60.0))
    assert np.allclose(got, 0.6 / np.pi * 0.5, rtol=1e-5)


def test_light_from_behind_either_normal_is_not_reflected() -> None:
    surface = surface_of(0.6, 0.04, 0.3)
    assert not value(surface, at_angle(30.0), at_angle(95.0)).any()
    surface.geometric_normal = wp.vec3(*at_angle(40.0, (-1.0, 0.0, 0.0)))
    assert value(surface, at_angle(0.0), at_angle(45.0)).any()
    assert not value(surface, at_angle(0.0), at_angle(55.0)).any()


def test_it_is_reciprocal() -> None:
    surface = surface_of(0.0, 0.3, 0.4)
    a, b = at_angle(25.0), at_angle(70.0, (0.3, 1.0, 0.0))
    there, back = value(surface, a, b) / (b @ NORMAL), value(surface, b, a) / (a @ NORMAL)
    assert np.allclose(there, back, rtol=1e-4)


@pytest.mark.parametrize("degrees", [0.0, 50.0, 80.0])
@pytest.mark.parametrize("roughness", [0.1, 0.4, 1.0])
def test_samples_of_the_lobe_have_their_density_and_lose_no_energy(roughness: float, degrees: float) -> None:
    surface, view = surface_of(0.0, 1.0, roughness), wp.vec3(*at_angle(degrees))
    energy, above, ratio = results(albedo_kernel, COUNT, [surface, view], wp.vec3).T
    assert np.allclose(ratio[above > 0.0], 1.0, rtol=1e-4)
    # One scattering: rough surfaces lose what would leave after more, smooth ones next to nothing.
    assert energy.mean() <= 1.0 + 1e-3
    assert energy.mean() > (0.97 if roughness < 0.3 else 0.3)
    if roughness == 1.0 and degrees == 0.0:
        assert energy.mean() == pytest.approx(1.0 - np.log(2.0), rel=1e-3)  # the integral in closed form for α = 1
    if roughness > 0.3:
        uniform, density = results(uniform_kernel, 1 << 17, [surface, view], wp.vec2).T
        assert uniform.mean() == pytest.approx(energy.mean(), rel=0.03)
        assert density.mean() == pytest.approx(above.mean(), rel=0.03)


def test_a_faint_lobe_fades_out_with_its_reflectance() -> None:
    grazing = at_angle(85.0), at_angle(85.0, (-1.0, 0.0, 0.0))
    full, faint = (value(surface_of(0.0, f0, 0.3), *grazing)[0] for f0 in (0.02, 0.001))
    assert faint == pytest.approx(0.05 * full, rel=0.05)


def test_the_lobe_fades_where_less_than_2_percent_is_reflected_at_normal_incidence() -> None:
    view, light = at_angle(85.0), at_angle(85.0, (-1.0, 0.0, 0.0))
    faint, least, usual = (value(surface_of(0.0, f0, 0.3), view, light)[0] for f0 in (0.01, 0.02, 0.04))
    assert faint == pytest.approx(0.5 * least, rel=1e-4)
    rise = (1.0 - np.cos(np.radians(85.0))) ** 5
    assert usual / least == pytest.approx((0.04 + 0.96 * rise) / (0.02 + 0.98 * rise), rel=1e-3)

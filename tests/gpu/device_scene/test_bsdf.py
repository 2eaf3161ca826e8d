import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.core.constants import PI
from gpu.device_scene.bsdf import reflected, sample_brdf, sample_specular, specular_density, specular_share
from gpu.device_scene.even_light import even_reflectance
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


@wp.kernel
def mirror_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    sample = sample_brdf(surface, view, 0.5, 0.3, 0.7)
    out[3 * index] = sample.direction
    out[3 * index + 1] = sample.weight
    out[3 * index + 2] = wp.vec3(sample.density, 0.0, 0.0)


@wp.kernel
def share_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[float]) -> None:
    out[first + wp.tid()] = specular_share(surface, view)


@wp.kernel
def even_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    out[first + wp.tid()] = even_reflectance(surface, view)


def surface_of(diffuse: float, f0: float, roughness: float, f90: float = 1.0) -> Surface:
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*NORMAL)
    surface.diffuse, surface.f0 = wp.vec3(diffuse, diffuse, diffuse), wp.vec3(f0, f0, f0)
    surface.f90, surface.roughness = f90 if f0 > 0.0 else 0.0, roughness
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


def test_the_specular_factor_fades_the_lobe_and_a_low_index_does_not() -> None:
    view, light = at_angle(85.0), at_angle(85.0, (-1.0, 0.0, 0.0))
    half, full, water = (value(surface_of(0.0, f0, 0.3, f90), view, light)[0]
                         for f0, f90 in ((0.02, 0.5), (0.04, 1.0), (0.02, 1.0)))  # fmt: skip
    assert half == pytest.approx(0.5 * full, rel=1e-4)
    rise = (1.0 - np.cos(np.radians(85.0))) ** 5
    assert full / water == pytest.approx((0.04 + 0.96 * rise) / (0.02 + 0.98 * rise), rel=1e-3)


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("grain", [0.5, 1.0])
def test_even_reflectance_is_what_lobes_along_a_grain_reflect(roughness: float, grain: float) -> None:
    surface = surface_of(0.0, 1.0, roughness)
    surface.grain = wp.vec3(grain, 0.0, 0.0)
    for cosine in (1.0, 0.6):
        lean = np.degrees(np.arccos(cosine))
        views = [wp.vec3(*at_angle(lean, (np.cos(turn), np.sin(turn), 0.1))) for turn in (0.1, 0.9, 1.7, 2.5)]
        kept = [results(albedo_kernel, 1 << 13, [surface, view], wp.vec3)[:, 0].mean() for view in views]
        even = results(even_kernel, 1, [surface, views[0]], wp.vec3)[0, 0]
        assert np.mean(kept) == pytest.approx(even, abs=0.04)


@pytest.mark.parametrize(("roughness", "lost"), [(0.5, 0.12), (1.0, 0.59)])
def test_rough_metals_lose_what_the_documentation_says(roughness: float, lost: float) -> None:
    heights = (np.arange(16) + 0.5) / 16  # of the cosine's square: a diffuse furnace
    angles = np.degrees(np.arccos(np.sqrt(heights)))
    surface = surface_of(0.0, 1.0, roughness)
    kept = [results(albedo_kernel, 1 << 12, [surface, wp.vec3(*at_angle(a))], wp.vec3)[:, 0].mean() for a in angles]
    assert 1.0 - np.mean(kept) == pytest.approx(lost, abs=0.015)


def test_a_perfect_mirror_reflects_by_its_fresnel_term() -> None:
    surface = surface_of(0.0, 0.5, 0.0)
    surface.mirror = True
    direction, weight, density = results(
        mirror_kernel, 1, [surface, wp.vec3(*at_angle(60.0))], wp.vec3, width=3
    )  # fmt: skip
    assert np.allclose(direction, at_angle(60.0, (-1.0, 0.0, 0.0)), atol=1e-6)
    assert np.allclose(weight, 0.5 + 0.5 * 0.5**5, rtol=1e-5)
    assert density[0] == 0.0


def test_each_of_two_lobes_has_a_tenth_of_the_samples_however_little_it_reflects() -> None:
    view = wp.vec3(*NORMAL)
    for diffuse, f0, share in (
        (0.9, 1e-4, 0.1),
        (1e-4, 0.9, 0.9),
        (0.5, 0.5, 2.0 / 3.0),
        (0.9, 0.0, 0.0),
        (0.0, 0.5, 1.0),
    ):
        assert results(share_kernel, 1, [surface_of(diffuse, f0, 0.4), view], float)[0] == pytest.approx(
            share, abs=0.03
        )


def test_even_light_is_reflected_as_its_fit_says() -> None:
    """Of metals and of dielectrics, smooth and rough, seen from anywhere."""
    missed = []
    for diffuse, f0 in ((0.0, 1.0), (0.0, 0.5), (0.0, 0.04), (0.7, 0.04)):
        for roughness in (0.1, 0.3, 0.6, 1.0):
            for degrees in (0.0, 40.0, 70.0, 84.0):
                surface, view = surface_of(diffuse, f0, roughness), wp.vec3(*at_angle(degrees))
                kernel, args = (uniform_kernel, [surface, view]) if diffuse else (albedo_kernel, [surface, view])
                exact = results(kernel, COUNT, args, wp.vec2 if diffuse else wp.vec3)[:, 0].mean()
                if diffuse and roughness < 0.3:
                    continue  # too narrow a lobe for directions from all around
                missed.append(results(even_kernel, 1, args, wp.vec3)[0, 0] - exact)
    assert np.abs(missed).mean() < 0.015
    assert np.abs(missed).max() < 0.1


@pytest.mark.parametrize(("diffuse", "f0", "most"), [(0.85, 0.04, 0.001), (0.0, 0.04, 0.001), (0.0, 1.0, 0.003)])
@pytest.mark.parametrize("roughness", [0.35, 0.6, 0.9])
def test_a_white_room_keeps_the_light_that_its_surfaces_reflect(
    roughness: float, diffuse: float, f0: float, most: float
) -> None:
    """Over all views, by their cosine, the fit has what `reflected` has: light that goes to and fro depends on that."""
    surface, missed = surface_of(diffuse, f0, roughness), []
    for height in (np.arange(8) + 0.5) / 8:
        view = wp.vec3(*at_angle(np.degrees(np.arccos(np.sqrt(height)))))
        exact = results(uniform_kernel, 1 << 14, [surface, view], wp.vec2)[:, 0].mean()
        missed.append(results(even_kernel, 1, [surface, view], wp.vec3)[0, 0] - exact)
    assert abs(np.mean(missed)) < most


def test_matt_surfaces_reflect_their_base_colour() -> None:
    surface = surface_of(0.3, 0.0, 1.0)
    surface.albedo = wp.vec3(0.3, 0.5, 0.7)
    assert np.allclose(results(even_kernel, 1, [surface, wp.vec3(*at_angle(50.0))], wp.vec3), (0.3, 0.5, 0.7))

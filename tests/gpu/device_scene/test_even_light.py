import numpy as np
import pytest
import warp as wp
from scenes import results

from gpu.device_scene.even_light import even_reflectance, over_even
from gpu.device_scene.scattering import sample_scattering
from gpu.device_scene.surface import Surface
from gpu.sampling.sobol import sobol_pair

NORMAL = wp.vec3(0.0, 0.6, 0.8)


@wp.kernel
def even_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """What is reflected of even light, and a sample of that."""
    index = first + wp.tid()
    place = sobol_pair(index, 0, 1)
    out[2 * index] = even_reflectance(surface, view)
    out[2 * index + 1] = sample_scattering(surface, view, sobol_pair(index, 1, 1).x, place.x, place.y).weight


@wp.kernel
def over_even_kernel(first: int, surface: Surface, view: wp.vec3, even: wp.vec3, out: wp.array[wp.vec3]) -> None:
    out[first + wp.tid()] = over_even(surface, view, surface.normal, even)


def surface_of(diffuse: float, through: float, f0: float) -> Surface:
    surface = Surface()
    surface.normal = surface.geometric_normal = NORMAL
    surface.albedo = wp.vec3(1.0, 1.0, 1.0)
    surface.diffuse, surface.through, surface.f0 = wp.vec3(diffuse), wp.vec3(through), wp.vec3(f0)
    surface.f90, surface.roughness = float(f0 > 0.0), 0.6
    return surface


@pytest.mark.parametrize(("diffuse", "through"), [(0.25, 0.5), (0.0, 0.75), (0.5, 0.0)])
@pytest.mark.parametrize("f0", [0.0, 0.04])
def test_what_is_translucent_is_lit_evenly_from_both_sides(diffuse: float, through: float, f0: float) -> None:
    if f0 == through == 0.0:
        return  # its base colour
    found = results(even_kernel, 1 << 12, [surface_of(diffuse, through, f0), NORMAL], wp.vec3, width=2)
    assert found[1::2].mean() == pytest.approx(found[0, 0], abs=0.015)


def test_a_direction_counts_by_what_is_reflected_of_it_over_even_light() -> None:
    surface = surface_of(0.25, 0.0, 0.0)
    assert results(over_even_kernel, 1, [surface, NORMAL, wp.vec3(0.5)], wp.vec3)[0] == pytest.approx(np.full(3, 0.5))

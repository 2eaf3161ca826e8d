import numpy as np
import pytest
import warp as wp
from scenes import results

from gpu.device_scene.even_light import even_reflectance, matt_side, over_even, turned
from gpu.device_scene.scattering import sample_scattering
from gpu.device_scene.surface import Surface, below_film, below_sheen
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


@wp.kernel
def side_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """What the other side sends, and a sample of that; how its normal is turned, in red."""
    index = first + wp.tid()
    seen = surface
    if surface.sheen_roughness > 0.0:
        seen = below_sheen(surface, view, surface.sheen, surface.sheen_roughness)
    if surface.film > 0.0:
        seen = below_film(surface, view, surface.film, 1.8, 300.0)
    place = sobol_pair(index, 0, 1)
    sample = sample_scattering(seen, view, sobol_pair(index, 1, 1).x, place.x, place.y)
    other = turned(seen, view)
    out[3 * index] = other.diffuse
    if wp.dot(sample.direction, NORMAL) < 0.0:
        out[3 * index + 1] = sample.weight
    out[3 * index + 2] = wp.vec3(wp.dot(other.geometric_normal, NORMAL), 0.0, 0.0)


@wp.kernel
def matt_side_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """Of evenly spread choices: what a side reflects, by whether it is that which is seen."""
    index = first + wp.tid()
    side = matt_side(surface, view, 0.0, (float(index) + 0.5) / 1000.0)
    out[2 * index + wp.where(wp.dot(side.normal, NORMAL) > 0.0, 0, 1)] = side.diffuse


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


@pytest.mark.parametrize("layer", ["none", "film", "sheen"])
@pytest.mark.parametrize("cosine", [1.0, 0.6])
def test_the_other_side_sends_what_goes_through_to_the_viewer(layer: str, cosine: float) -> None:
    surface = surface_of(0.25, 0.5, 0.04)
    if layer == "film":
        surface.film = 1.0
    elif layer == "sheen":
        surface.sheen, surface.sheen_roughness = wp.vec3(0.8, 0.4, 0.2), 0.5
    lean = (1.0 - cosine**2) ** 0.5
    view = wp.vec3(*(cosine * np.array(NORMAL) + lean * np.array([1.0, 0.0, 0.0])))
    found = results(side_kernel, 1 << 13, [surface, view], wp.vec3, width=3)
    assert found[1::3].mean(axis=0) == pytest.approx(found[0], abs=0.02)
    assert found[2, 0] == pytest.approx(-1.0)


def test_sides_are_chosen_by_what_they_send_and_in_the_mean_send_that() -> None:
    found = results(matt_side_kernel, 1000, [surface_of(0.2, 0.6, 0.0), NORMAL], wp.vec3, width=2)
    front, behind = found[0::2], found[1::2]
    assert (behind.mean(), front.mean()) == pytest.approx((0.6, 0.2), rel=1e-3)
    assert (behind[:, 0] > 0.0).mean() == pytest.approx(0.75, abs=1e-3)

"""The whole BSDF: frequencies of its samples against its densities (χ²), reciprocity, and energy in a white furnace."""

from itertools import product

import numpy as np
import pytest
import warp as wp
from scenes import column, results
from scipy import stats

from gpu.device_scene.scattering import (
    choose_part,
    is_narrow,
    is_perfect,
    part_of,
    sample_scattering,
    scattered,
    scattering_density,
)
from gpu.device_scene.surface import Surface, below_sheen
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.scene.types import Doubles

NORMAL, SIDE = np.array([0.48, -0.6, 0.64]), np.array([0.8, 0.0, -0.6])
GRAIN = np.cross(NORMAL, SIDE) * 0.8 + SIDE * 0.6
# Of the cells: where they meet, the grid is coarse, so it is aside of all lobes.
AXIS = np.cross(NORMAL, SIDE)
SAMPLES = 1 << 15
HEIGHTS, AZIMUTHS, INSIDE = 10, 16, 20
SIGNIFICANCE = 0.01


@wp.func
def seen_from(surface: Surface, view: wp.vec3) -> Surface:
    """As gpu.device_scene.surface.surface_at tells."""
    if surface.sheen_roughness > 0.0:
        return below_sheen(surface, view, surface.sheen, surface.sheen_roughness)
    return surface


@wp.kernel
def scattering_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """(direction, weight) of an independent sample; a direction of zero where nothing is scattered."""
    index = first + wp.tid()
    seed = pixel_seed(index, 5)
    place = sobol_pair(0, 0, seed)
    sample = sample_scattering(seen_from(surface, view), view, sobol_pair(0, 1, seed).x, place.x, place.y)
    if wp.length_sq(sample.weight) > 0.0:
        out[2 * index] = sample.direction
        out[2 * index + 1] = sample.weight


@wp.kernel
def value_kernel(first: int, surface: Surface, view: wp.vec3, lights: wp.array[wp.vec3],
                 out: wp.array[wp.vec2]) -> None:  # fmt: skip
    """(density, green of BSDF · cosine) of each direction."""
    index = first + wp.tid()
    light = lights[index]
    seen = seen_from(surface, view)
    out[index] = wp.vec2(scattering_density(seen, view, light), scattered(seen, view, light)[1])


@wp.kernel
def choice_kernel(first: int, surface: Surface, choices: wp.array[float], out: wp.array[wp.vec4]) -> None:
    index = first + wp.tid()
    chosen = choose_part(surface, surface.normal, choices[index])
    out[index] = wp.vec4(
        chosen.glass, chosen.rest, float(int(is_perfect(surface))), float(int(is_narrow(surface)))
    )  # fmt: skip


def surface_of(roughness: float, *, diffuse: float = 0.0, f0: float = 0.0, glass: float = 0.0, eta: float = 1.5,
               thin: bool = False, flipped: bool = False,
               sheen: tuple[float, float] = (0.0, 0.0), film: float = 0.0,
               grain: float = 0.0, through: float = 0.0) -> Surface:  # fmt: skip
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*(-NORMAL if flipped else NORMAL))
    surface.albedo, surface.diffuse, surface.f0 = wp.vec3(1.0, 1.0, 1.0), wp.vec3(diffuse), wp.vec3(f0)
    surface.f90, surface.roughness = float(f0 > 0.0), roughness
    surface.glass, surface.eta, surface.thin, surface.clear = glass, eta, thin, roughness == 0.0
    surface.sheen, surface.sheen_roughness = wp.vec3(sheen[0]), sheen[1]
    surface.grain, surface.through = wp.vec3(*(grain * GRAIN)), wp.vec3(through)
    surface.film, surface.film_ior, surface.film_thickness, surface.film_f0 = film, 1.8, 250.0, wp.vec3(f0)
    return surface


def at_angle(degrees: float) -> Doubles:
    return np.asarray(np.cos(np.radians(degrees)) * NORMAL + np.sin(np.radians(degrees)) * SIDE)


def samples_of(surface: Surface, view: Doubles) -> tuple[Doubles, Doubles]:
    """Directions (sample, 3) and weights (sample, 3)."""
    found = results(scattering_kernel, SAMPLES, [surface, wp.vec3(*view)], wp.vec3, width=2)
    return found[0::2], found[1::2]


def values(surface: Surface, view: Doubles, lights: Doubles) -> Doubles:
    """(density, BSDF · cosine) of each of the directions (light, 3)."""
    return results(value_kernel, len(lights), [surface, wp.vec3(*view), column(lights, wp.vec3)], wp.vec2)


def cells_of(directions: Doubles, axis: Doubles) -> Doubles:
    """The number of each direction's cell, of equal solid angle about `axis`."""
    u = np.cross(axis, [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    heights = np.clip((directions @ axis + 1.0) / 2.0 * HEIGHTS, 0, HEIGHTS - 1).astype(int)
    azimuth = (np.arctan2(directions @ v, directions @ u) / (2.0 * np.pi)) % 1.0
    return np.asarray(heights * AZIMUTHS + np.clip((azimuth * AZIMUTHS).astype(int), 0, AZIMUTHS - 1))


def sphere(axis: Doubles) -> Doubles:
    """Directions of a fine grid, each for the same solid angle."""
    u = np.cross(axis, [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    height = (np.arange(HEIGHTS * INSIDE) + 0.5) / (HEIGHTS * INSIDE) * 2.0 - 1.0
    turn = (np.arange(AZIMUTHS * INSIDE) + 0.5) / (AZIMUTHS * INSIDE) * 2.0 * np.pi
    z, angle = (grid.ravel() for grid in np.meshgrid(height, turn, indexing="ij"))
    radius = np.sqrt(1.0 - z * z)
    return np.asarray(
        z[:, None] * axis
        + (radius * np.cos(angle))[:, None] * u
        + (radius * np.sin(angle))[:, None] * np.cross(axis, u)
    )


CASES = {
    "matt": surface_of(1.0, diffuse=0.5),
    "plastic": surface_of(0.4, diffuse=0.5, f0=0.04),
    "metal": surface_of(0.5, f0=0.9),
    "rough metal": surface_of(1.0, f0=0.9),
    "brushed metal": surface_of(0.5, f0=0.9, grain=0.4),
    "brushed lacquer": surface_of(0.4, diffuse=0.5, f0=0.04, grain=0.1),
    "frosted body": surface_of(0.5, glass=1.0),
    "rough body": surface_of(0.9, glass=1.0),
    "dense body": surface_of(0.6, glass=1.0, eta=2.4),
    "frosted body from inside": surface_of(0.6, glass=1.0, eta=1.0 / 1.5),
    "frosted sheet": surface_of(0.5, glass=1.0, thin=True),
    "cloth": surface_of(0.9, diffuse=0.5, f0=0.04, sheen=(0.8, 0.6)),
    "velvet": surface_of(1.0, sheen=(1.0, 0.3)),
    "plastic with a film": surface_of(0.4, diffuse=0.5, f0=0.04, film=1.0),
    "metal with a film": surface_of(0.5, f0=0.9, film=0.5),
    "body with a film": surface_of(0.5, f0=0.04, glass=1.0, film=1.0),
    "film from inside a body": surface_of(0.6, f0=0.04, glass=1.0, eta=1.0 / 1.5, film=1.0),
    "sheet with a film": surface_of(0.5, f0=0.04, glass=1.0, thin=True, film=1.0),
    "paper": surface_of(1.0, diffuse=0.5, through=0.25, thin=True),
    "lampshade": surface_of(1.0, through=0.5, thin=True),
    "leaf": surface_of(0.4, diffuse=0.3, through=0.5, f0=0.04, thin=True),
    "curtain": surface_of(0.9, diffuse=0.5, through=0.3, f0=0.04, sheen=(0.8, 0.6), thin=True),
    "wing": surface_of(0.4, diffuse=0.1, through=0.8, f0=0.04, film=1.0, thin=True),
    "cloth of metal": surface_of(0.5, f0=0.9, sheen=(0.5, 0.5)),
}


@pytest.mark.parametrize("degrees", [0.0, 50.0, 80.0])
@pytest.mark.parametrize("case", list(CASES))
def test_samples_have_their_density_and_weigh_what_is_scattered(case: str, degrees: float) -> None:
    surface, view = CASES[case], at_angle(degrees)
    directions, weights = samples_of(surface, view)
    drawn = np.any(directions != 0.0, axis=1)
    grid = sphere(AXIS)
    density, value = (4.0 * np.pi * values(surface, view, grid)).T
    cell, cells = cells_of(grid, AXIS), HEIGHTS * AZIMUTHS
    # Samples that point into the surface have a density, too, but scatter nothing.
    expected = np.bincount(cell, density * (value > 0.0), cells) / len(grid) * SAMPLES
    found = np.bincount(cells_of(directions[drawn], AXIS), minlength=cells)
    enough = expected > 8.0
    assert abs((found - expected)[~enough].sum()) <= 0.001 * SAMPLES
    chi2 = ((found - expected)[enough] ** 2 / (expected + (0.004 * expected) ** 2)[enough]).sum()
    assert stats.chi2.sf(chi2, enough.sum()) > SIGNIFICANCE / (3 * len(CASES))
    assert weights[:, 1].mean() == pytest.approx(value.mean(), rel=0.02)


@pytest.mark.parametrize("case", list(CASES))
def test_scattering_is_reciprocal(case: str) -> None:
    surface, eta = CASES[case], CASES[case].eta
    for a, b in product((20.0, 65.0), (-10.0, -70.0, 120.0, 170.0)):
        view, light = at_angle(a), at_angle(b)
        there = values(surface, view, light[None])[0, 1] / abs(light @ NORMAL)
        crosses = light @ NORMAL < 0.0
        other = Surface()
        for name in Surface.vars:
            setattr(other, name, getattr(surface, name))
        if crosses:
            other.normal = other.geometric_normal = wp.vec3(*-NORMAL)
            other.eta = eta if surface.thin else 1.0 / eta
        back = values(other, light, view[None])[0, 1] / abs(view @ NORMAL)
        # Radiance over the square of the index is what both ways have in common.
        scale = eta**2 if crosses and not surface.thin else 1.0
        assert there * scale == pytest.approx(back, rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("degrees", [0.0, 60.0, 80.0])
def test_glass_keeps_all_light_but_for_masking(degrees: float) -> None:
    for eta, thin, roughness in ((1.5, False, 0.0), (1.5, True, 0.0), (1.0 / 1.5, False, 0.0), (1.5, False, 0.3)):
        surface = surface_of(roughness, glass=1.0, eta=eta, thin=thin)
        directions, weights = samples_of(surface, at_angle(degrees))
        crossed = directions @ NORMAL < 0.0
        total = np.where(crossed & (not thin), weights[:, 1] * eta**2, weights[:, 1]).mean()
        assert total == pytest.approx(1.0, abs=1e-5 if roughness == 0.0 else 0.07)


@pytest.mark.parametrize("through", [0.0, 0.5, 1.0])
def test_white_plastic_gains_at_most_a_twentieth_in_a_furnace(through: float) -> None:
    surface = surface_of(0.3, diffuse=1.0 - through, through=through, f0=0.04, thin=True)
    heights = (np.arange(16) + 0.5) / 16
    energy = [samples_of(surface, at_angle(float(np.degrees(np.arccos(h**0.5)))))[1].mean() for h in heights]
    assert 1.0 < np.mean(energy) < 1.05


def test_what_is_translucent_scatters_its_share_to_either_side() -> None:
    directions, weights = samples_of(surface_of(1.0, diffuse=0.5, through=0.25, thin=True), at_angle(40.0))
    behind = directions @ NORMAL < 0.0
    sent = [np.where(side, weights[:, 1], 0.0).mean() for side in (~behind, behind)]
    assert sent == pytest.approx([0.5, 0.25], rel=0.01)


def test_a_path_takes_glass_by_its_share() -> None:
    choices = column([0.0, 0.2, 0.3, 0.9], float)
    found = results(choice_kernel, 4, [surface_of(0.6, diffuse=0.5, glass=0.25), choices], wp.vec4)
    assert found[:, 0].tolist() == [1.0, 1.0, 0.0, 0.0]
    assert np.allclose(found[:, 1], [0.0, 0.8, 0.05 / 0.75, 0.65 / 0.75], atol=1e-6)


def test_perfect_and_narrow_parts_are_told_apart() -> None:
    mirror = surface_of(0.05, f0=0.5)
    mirror.mirror = True
    cases = [surface_of(0.0, glass=1.0), surface_of(0.5, glass=1.0), mirror, surface_of(0.4, f0=0.04),
             surface_of(0.4, diffuse=0.5), surface_of(0.6, f0=0.04)]  # fmt: skip
    found = [results(choice_kernel, 1, [case, column([0.5], float)], wp.vec4)[0, 2:].tolist() for case in cases]
    assert found == [[1, 1], [0, 1], [1, 1], [0, 1], [0, 0], [0, 0]]


@wp.kernel
def part_kernel(first: int, surface: Surface, view: wp.vec3, choices: wp.array[float], out: wp.array[wp.vec4]) -> None:
    """(whether it is the coat, rest, roughness, green of the part's diffuse and f0 and its shares left) of a choice."""
    index = first + wp.tid()
    chosen = choose_part(surface, view, choices[index])
    part = part_of(surface, chosen)
    left = part.diffuse[1] + 10.0 * part.f0[1] + 100.0 * part.glass + 1000.0 * part.coat
    out[index] = wp.vec4(float(int(chosen.coat)), chosen.rest, part.roughness, left)


@pytest.mark.parametrize("degrees", [0.0, 70.0])
def test_a_coat_takes_what_it_reflects(degrees: float) -> None:
    surface = surface_of(0.6, diffuse=0.5, f0=0.04, glass=0.25)
    surface.coat, surface.coat_roughness, surface.coat_normal = 0.8, 0.1, surface.normal
    share = 0.8 * (0.04 + 0.96 * (1.0 - np.cos(np.radians(degrees))) ** 5)
    choices = np.array([0.5 * share, share + 0.1 * (1.0 - share), share + 0.5 * (1.0 - share)])
    inputs = [surface, wp.vec3(*at_angle(degrees)), column(choices, float)]
    coat, rest, roughness, left = results(part_kernel, 3, inputs, wp.vec4).T
    assert coat.tolist() == [1.0, 0.0, 0.0]
    assert np.allclose(rest, [0.5, 0.4, 0.25 / 0.75], atol=1e-4)
    assert np.allclose(roughness, [0.1, 0.6, 0.6])
    assert np.allclose(left, [10.0, 100.9, 0.9], atol=1e-4)

"""Sampled frequencies of directions against the densities that weigh them, by the χ² test, as Mitsuba has it.

Lamps are cut into patches and the sphere into cells of equal solid angle; what a density says of each is integrated
with points of a grid. The marginals of simple mappings are in tests/gpu/test_sampling.py.
"""

from collections.abc import Callable

import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of, results
from scipy import stats

from gpu.device_scene.bsdf import sample_specular, specular_density
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.surface import Surface
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Sky

SAMPLES = 1 << 17
# Cells along the height and the azimuth, and grid points along each side of one.
HEIGHTS, AZIMUTHS, INSIDE = 12, 24, 32
PATCHES = 8
# How far the integrals may be off together.
INTEGRATED = 2e-3
Density = Callable[[Doubles], Doubles]
SIGNIFICANCE = 0.01
FAR = wp.constant(10.0)


@wp.kernel
def light_kernel(first: int, scene: SceneData, table: LightTable, position: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """(direction, point) of an independent light sample; zero for one of no density."""
    index = first + wp.tid()
    seed = pixel_seed(index, 3)
    pick = sobol_pair(0, 0, seed)
    sample = sample_light(scene, table, table.all_emitters, position, pick.a, sobol_pair(0, 1, seed))
    if sample.solid_angle > 0.0:
        out[2 * index] = sample.direction
        out[2 * index + 1] = sample.point


@wp.kernel
def light_density_kernel(first: int, scene: SceneData, table: LightTable, position: wp.vec3,
                         directions: wp.array[wp.vec3], out: wp.array[float]) -> None:  # fmt: skip
    index = first + wp.tid()
    hit = closest_hit(scene, position, directions[index], FAR)
    out[index] = light_at_hit(scene, table, table.all_emitters, position, directions[index], hit).density


@wp.kernel
def lobe_kernel(first: int, surface: Surface, view: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """The direction of an independent sample of the specular lobe; zero for one into the surface."""
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 5))
    sample = sample_specular(surface, view, point.x, point.y)
    if sample.density > 0.0:
        out[index] = sample.direction


@wp.kernel
def lobe_density_kernel(first: int, surface: Surface, view: wp.vec3, directions: wp.array[wp.vec3],
                        out: wp.array[float]) -> None:  # fmt: skip
    index = first + wp.tid()
    if wp.dot(directions[index], surface.normal) > 0.0:
        out[index] = specular_density(surface, view, directions[index])


@wp.kernel
def cosine_kernel(first: int, axis: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """The direction that an independent point is mapped to."""
    index = first + wp.tid()
    point = sobol_pair(0, 0, pixel_seed(index, 7))
    out[index] = cosine_direction(axis, point.x, point.y)


def grid() -> Doubles:
    """Directions (cell, point, 3) in the middles of equal parts of each cell."""
    rows, columns = HEIGHTS * INSIDE, AZIMUTHS * INSIDE
    height = -1.0 + (np.arange(rows) + 0.5) * 2.0 / rows
    azimuth = -np.pi + (np.arange(columns) + 0.5) * 2.0 * np.pi / columns
    radius = np.sqrt(1.0 - height**2)[:, None]
    directions = np.stack(
        [radius * np.cos(azimuth), radius * np.sin(azimuth), np.broadcast_to(height[:, None], (rows, columns))], axis=2
    )
    parts = directions.reshape(HEIGHTS, INSIDE, AZIMUTHS, INSIDE, 3).swapaxes(1, 2)
    return np.asarray(parts.reshape(HEIGHTS * AZIMUTHS, INSIDE**2, 3))


def p_value(found: Doubles, shares: Doubles) -> float:
    """Of the χ² test that of SAMPLES samples `found` (cell,) fell where there should be `shares` of them.

    Samples that are none, and what is left of the shares, make a cell more.
    """
    few = shares * SAMPLES < 20.0  # put together with those, as the test's approximation asks for
    assert (~few).sum() > 1
    found, expected = found[~few], shares[~few] * SAMPLES
    rest, lost = SAMPLES - expected.sum(), SAMPLES - found.sum()
    if rest < INTEGRATED * SAMPLES:
        assert lost < rest + INTEGRATED * SAMPLES
    else:
        found, expected = np.append(found, lost), np.append(expected, rest)
    return float(stats.chisquare(found, expected * found.sum() / expected.sum()).pvalue)


def on_sphere(directions: Doubles, density: Density) -> float:
    """The p-value of `directions` (sample, 3), of which some may be zero, if their `density` [1/sr] is right."""
    drawn = directions[np.any(directions != 0.0, axis=1)]
    azimuth = np.arctan2(drawn[:, 1], drawn[:, 0])
    limits = [[-1.0, 1.0], [-np.pi, np.pi]]
    found = np.histogram2d(np.clip(drawn[:, 2], -1.0, 1.0), azimuth, (HEIGHTS, AZIMUTHS), limits)[0].ravel()
    at = grid()
    return p_value(found, density(at.reshape(-1, 3)).reshape(len(at), -1).mean(axis=1) * 4.0 * np.pi / len(at))


def on_lamp(points: Doubles, lamp: MeshPart, place: Doubles, density: Density) -> tuple[Doubles, Doubles]:
    """How many of `points` (sample, 3) are in each patch of a lamp, and the share that `density` gives it."""
    corner, u, v = lamp.positions[0], lamp.positions[1] - lamp.positions[0], lamp.positions[3] - lamp.positions[0]
    normal = np.cross(u, v)
    offsets = points - corner
    here = offsets[np.abs(offsets @ normal) < 1e-5 * np.linalg.norm(normal)]
    found = np.histogram2d(here @ u / (u @ u), here @ v / (v @ v), PATCHES, [[-1e-6, 1 + 1e-6]] * 2)[0]
    ticks = (np.arange(PATCHES * INSIDE) + 0.5) / (PATCHES * INSIDE)
    ways = corner + ticks[:, None, None] * u + ticks[None, :, None] * v - place
    distance = np.linalg.norm(ways, axis=2)
    seen = np.abs(ways @ normal) / distance**3  # solid angle per share of the lamp's area
    amount = density((ways / distance[..., None]).reshape(-1, 3)).reshape(distance.shape) * seen
    return found.ravel(), amount.reshape(PATCHES, INSIDE, PATCHES, INSIDE).mean(axis=(1, 3)).ravel() / PATCHES**2


def lamps(*parts: MeshPart, sky: Sky | None = None, device: str) -> DeviceScene:
    """Lamps in a world that is unit space, since specks in two corners span it."""
    specks = [quad((x, x, x), (-1e-4 * np.sign(x), 0.0, 0.0), (0.0, -1e-4 * np.sign(x), 0.0)) for x in (-0.5, 0.5)]
    return resident_of([*specks, *parts], [grey(0.5), grey(0.0, 2.0), grey(0.0, 50.0)], sky=sky, device=device)


NEAR = quad((-0.45, 0.1, -0.3), (0.6, 0.0, 0.0), (0.0, 0.0, 0.6), 1)
SMALL = quad((0.3, 0.45, 0.3), (0.1, 0.0, 0.0), (0.0, 0.0, 0.1), 2)
UPRIGHT = quad((-0.4, -0.4, -0.1), (0.8, 0.0, 0.0), (0.0, 0.8, 0.0), 1)
SLIVER = quad((-0.4, 0.2, 0.0), (0.9, 0.0, 0.0), (0.0, 0.0, 1e-2), 1)
LIGHTS = {
    "by solid angle": ([NEAR], (0.1, -0.2, 0.1)),
    "by area": ([SMALL], (-0.3, -0.4, 0.1)),
    "both": ([NEAR, SMALL], (0.1, -0.3, 0.1)),
    "close above a lamp": ([UPRIGHT], (0.1, 0.1, -0.05)),
    "from the side": ([UPRIGHT], (0.6, 0.0, 0.1)),
    "a sliver": ([SLIVER], (0.1, 0.1, 0.0)),
}


def light_samples(device_scene: DeviceScene, place: Doubles) -> tuple[Doubles, Doubles, Density]:
    """Directions and points (sample, 3) of light samples at `place`, and the density of light met from there."""
    device, table = str(device_scene.device), build_light_table(device_scene)
    inputs = [device_scene.data, table, wp.vec3(*place)]
    drawn = results(light_kernel, SAMPLES, inputs, wp.vec3, 2, device).reshape(SAMPLES, 2, 3)

    def density(at: Doubles) -> Doubles:
        inputs = [device_scene.data, table, wp.vec3(*place), column(at, wp.vec3, device)]
        return results(light_density_kernel, len(at), inputs, float, device=device)

    return drawn[:, 0], drawn[:, 1], density


@pytest.mark.parametrize("case", list(LIGHTS))
def test_samples_of_lamps(device: str, case: str) -> None:
    parts, place = LIGHTS[case]
    directions, points, density = light_samples(lamps(*parts, device=device), place)
    drawn = np.any(directions != 0.0, axis=1)
    patches = [on_lamp(points[drawn], lamp, np.array(place), density) for lamp in parts]
    found, shares = np.concatenate(patches, axis=1)
    assert found.sum() == drawn.sum()
    assert p_value(found, shares) > SIGNIFICANCE / len(LIGHTS)


def test_samples_of_the_sky(device: str) -> None:
    directions, _, density = light_samples(lamps(sky=Sky((1.0, 2.0, 3.0)), device=device), np.zeros(3))
    assert on_sphere(directions, density) > SIGNIFICANCE


@pytest.mark.parametrize("degrees", [0.0, 60.0, 85.0])
@pytest.mark.parametrize("roughness", [0.3, 0.5, 1.0])
def test_samples_of_the_specular_lobe(device: str, roughness: float, degrees: float) -> None:
    normal, side = np.array([0.48, -0.6, 0.64]), np.array([0.8, 0.0, -0.6])
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*normal)
    surface.f0, surface.roughness = wp.vec3(1.0, 1.0, 1.0), roughness
    view = wp.vec3(*(np.cos(np.radians(degrees)) * normal + np.sin(np.radians(degrees)) * side))
    directions = results(lobe_kernel, SAMPLES, [surface, view], wp.vec3, device=device)

    def density(at: Doubles) -> Doubles:
        inputs = [surface, view, column(at, wp.vec3, device)]
        return results(lobe_density_kernel, len(at), inputs, float, device=device)

    assert on_sphere(directions, density) > SIGNIFICANCE / 9


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.48, -0.6, 0.64)])
def test_cosine_directions(device: str, axis: tuple[float, float, float]) -> None:
    directions = results(cosine_kernel, SAMPLES, [wp.vec3(*axis)], wp.vec3, device=device)
    assert on_sphere(directions, lambda at: np.maximum(at @ np.array(axis), 0.0) / np.pi) > SIGNIFICANCE / 3

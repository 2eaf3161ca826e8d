"""Directions to a picture of the light around: where they see what, and how often they are drawn."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results
from scipy import stats

from gpu.device_scene.data import EnvironmentData
from gpu.device_scene.environment import (
    environment_density,
    environment_radiance,
    mean_radiance,
    sample_environment,
    upload_environment,
)
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.scene.types import Doubles, Environment, Floats

COUNT = 1 << 15
HEIGHT, WIDTH = 8, 16


@wp.kernel
def draw_kernel(first: int, environment: EnvironmentData, out: wp.array[wp.vec3]) -> None:
    """(direction, (density, density as told of it, radiance of green)) of an independent sample."""
    index = first + wp.tid()
    sample = sample_environment(environment, sobol_pair(0, 0, pixel_seed(index, 2)))
    told = environment_density(environment, sample.direction)
    out[2 * index] = sample.direction
    out[2 * index + 1] = wp.vec3(sample.density, told, environment_radiance(environment, sample.direction)[1])


@wp.kernel
def look_kernel(first: int, environment: EnvironmentData, ways: wp.array[wp.vec3], out: wp.array[wp.vec4]) -> None:
    """(radiance, density) of each direction."""
    index = first + wp.tid()
    seen = environment_radiance(environment, ways[index])
    out[index] = wp.vec4(seen[0], seen[1], seen[2], environment_density(environment, ways[index]))


def sky(turn: float = 0.0) -> Environment:
    """A dim picture with a few bright pixels, one of them black all around."""
    pixels = np.random.default_rng(4).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    pixels[2, 5] = (900.0, 600.0, 300.0)
    pixels[5, 14:] = 0.0
    return Environment("sky", pixels, turn)


def look(environment: Environment, ways: object) -> Doubles:
    data = upload_environment(environment, wp.get_device("cpu"))
    return results(look_kernel, len(np.asarray(ways)), [data, column(ways, wp.vec3)], wp.vec4)


def grid(rows: int, columns: int) -> tuple[Doubles, Doubles, Doubles]:
    """Directions (place, 3) that are spread evenly, and the picture's row and column of each."""
    height = 1.0 - 2.0 * (np.arange(rows) + 0.5) / rows
    across = (np.arange(columns) + 0.5) / columns
    z, u = (values.ravel() for values in np.meshgrid(height, across, indexing="ij"))
    angle, radius = (0.5 - u) * 2.0 * np.pi, np.sqrt(1.0 - z * z)
    ways = np.stack([radius * np.sin(angle), z, radius * np.cos(angle)], axis=1)
    return ways, np.arccos(z) / np.pi * HEIGHT, u * WIDTH


def test_samples_have_their_density_and_are_drawn_by_brightness() -> None:
    data = upload_environment(sky(0.3), wp.get_device("cpu"))
    found = results(draw_kernel, COUNT, [data], wp.vec3, width=2)
    directions, (density, told, green) = found[0::2], found[1::2].T
    assert np.allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-5)
    assert np.isclose(density, told, rtol=1e-3).mean() > 0.999  # but where rounding crosses a pixel's edge
    ways, row, across = grid(1024, 512)
    seen = look(sky(), ways)
    cell = row.astype(int) * WIDTH + across.astype(int)
    expected = np.bincount(cell, seen[:, 3], HEIGHT * WIDTH) * 4.0 * np.pi / len(ways) * COUNT
    azimuth = (0.5 - (np.arctan2(directions[:, 0], directions[:, 2]) / (2.0 * np.pi) - 0.3)) % 1.0
    own = (np.arccos(directions[:, 1]) / np.pi * HEIGHT).astype(int) * WIDTH + (azimuth * WIDTH).astype(int)
    counts = np.bincount(own, minlength=HEIGHT * WIDTH)
    enough = expected > 8.0
    assert expected.sum() == pytest.approx(COUNT, rel=2e-3)
    chi2 = ((counts - expected)[enough] ** 2 / expected[enough]).sum()
    assert stats.chi2.sf(chi2, enough.sum() - 1) > 0.01
    assert (green / density).mean() == pytest.approx(4.0 * np.pi * seen[:, 1].mean(), rel=0.01)
    # By brightness: one part of the estimate is about as large as another.
    assert (green / density).std() < (green / density).mean()


def test_the_middle_is_towards_z_and_a_quarter_from_the_left_towards_x() -> None:
    pixels = np.zeros((4, 8, 3), np.float32)
    pixels[:2] += [0.0, 0.0, 1.0]  # above
    pixels[:, 3:5] += [1.0, 0.0, 0.0]  # the middle
    pixels[:, 1:3] += [0.0, 1.0, 0.0]  # a quarter from the left
    ways = [[0.0, -0.1, 1.0], [1.0, -0.1, 0.0], [0.0, -0.1, -1.0], [0.0, 1.0, 0.0]]
    seen = look(Environment("", pixels), [np.array(way) / np.linalg.norm(way) for way in ways])[:, :3]
    assert np.argmax(seen[0]) == 0
    assert np.argmax(seen[1]) == 1
    assert seen[2][:2].tolist() == [0.0, 0.0]
    assert seen[3][2] == pytest.approx(1.0)
    # A quarter of a turn, counter-clockwise from above, takes what was seen towards +Z to +X.
    turned = look(Environment("", pixels, 0.25), [np.array(way) / np.linalg.norm(way) for way in ways])[:, :3]
    assert np.allclose(turned[1], seen[0], atol=1e-5)


def test_colours_are_interpolated_across_the_seam() -> None:
    pixels: Floats = np.zeros((2, 4, 3), np.float32)
    pixels[:, 0], pixels[:, 3] = 1.0, 3.0
    seen = look(Environment("", pixels), [[0.0, 0.0, -1.0]])
    assert seen[0, 0] == pytest.approx(2.0)


def test_the_mean_is_over_solid_angle() -> None:
    environment = sky()
    seen = look(environment, grid(1024, 512)[0])[:, :3]
    assert mean_radiance(environment) == pytest.approx(seen.mean(), rel=0.05)  # but for interpolation
    even = Environment("even", np.full((4, 8, 3), 0.5, np.float32))
    assert mean_radiance(even) == pytest.approx(0.5)

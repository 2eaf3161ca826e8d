"""White of a picture at whose probes the truth is known with noise."""

import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import column

from gpu.adaptive.probe_white_point import Picture, ProbeRadiance, WhitePoint, WhitePointParameters
from gpu.core.device import allocate, choose_device
from gpu.core.image_size import image_size
from gpu.core.parameters import parameters
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.sparse_shading import SparseShadingParameters

WIDTH, HEIGHT = 200, 100


def picture_of(
    radiance: np.ndarray, name: str, faces: np.ndarray | None = None, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> Picture:
    """A picture (pixel, 3) of white surfaces; faces (pixel,): what each pixel sees."""
    pixels, device = len(radiance), choose_device(name)
    gbuffer: GBuffer = allocate(GBuffer, pixels, device)
    gbuffer.albedo.fill_(wp.vec3(np.pi, np.pi, np.pi))
    gbuffer.throughput.fill_(1.0)
    gbuffer.face = column(np.zeros(pixels) if faces is None else faces, int, name)
    picture = Picture()
    picture.gbuffer, picture.image = gbuffer, image_size(size)
    picture.sparse = parameters(SparseShadingParameters, stride=1)
    picture.listed = wp.full(pixels, 1, dtype=int, device=device)
    picture.irradiance = column(radiance, wp.vec3, name)
    return picture


def found(
    picture: Picture,
    render: np.ndarray,
    one: np.ndarray,
    other: np.ndarray,
    counts: np.ndarray,
    frame: int = 0,
    chosen: WhitePointParameters | None = None,
) -> WhitePoint:
    """What is found with probes' values (probe, 3) and counts (probe,)."""
    device = picture.irradiance.device
    white = WhitePoint(WIDTH * HEIGHT, len(render), device, chosen)
    radiance = ProbeRadiance()
    radiance.render, radiance.one, radiance.other = (column(array, wp.vec3, device) for array in (render, one, other))
    white.find(column([frame], int, device), picture, column(counts, float, device), radiance)
    return white


def value(white: WhitePoint) -> float:
    """What white is, from what was found."""
    dark, bright = white.whole.numpy()[0].tolist()
    return float(white.quantiles.numpy()[1]) * bright / dark if dark > 0.0 else 0.0


@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("dimmed", [0.8, 1.0, 1.25])
def test_white_is_that_of_the_truth_whatever_noise_it_has_and_however_dim_the_render_is(
    dimmed: float, name: str
) -> None:
    """Bright probes are drawn more often, and so count for less."""
    random = np.random.default_rng(5)
    even = random.exponential(size=(WIDTH * HEIGHT, 3))
    bright = even.mean(axis=1)
    drawn = random.choice(len(bright), len(bright), p=bright / bright.sum())
    counts, truth = bright.mean() / bright[drawn], even[drawn]
    one, other = (truth * random.exponential(size=truth.shape) for _ in range(2))
    picture = picture_of(dimmed * even, name)
    assert value(found(picture, dimmed * truth, one, other, counts)) == pytest.approx(
        np.percentile(even, 99.0), rel=0.06
    )
    assert np.percentile(one, 99.0) > 1.3 * np.percentile(even, 99.0)


@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_quantiles_are_those_of_all_channels(scale: float, name: str) -> None:
    values = scale * np.random.default_rng(2).lognormal(sigma=3.0, size=(WIDTH * HEIGHT, 3))
    probes = np.ones((1, 3))
    white = found(picture_of(values, name), probes, probes, probes, np.ones(1))
    assert white.quantiles.numpy() == pytest.approx(np.percentile(values, [95.0, 99.0]), rel=0.006)


def test_what_is_dark_or_not_finite_is_below_all_others_and_pixels_that_see_nothing_are_black() -> None:
    values = np.ones((WIDTH * HEIGHT, 3))
    values[::2] = 0.0
    values[1::50] = np.nan
    faces = np.zeros(len(values))
    faces[3::10] = int(NO_HIT)
    probes = np.ones((1, 3))
    white = found(picture_of(values, "cpu", faces), probes, probes, probes, np.ones(1))
    lit = (faces == 0) & (values[:, 0] > 0.0)
    assert white.lit.numpy()[0] == np.count_nonzero(lit)
    assert white.even == len(values)
    assert white.quantiles.numpy() == pytest.approx([1.0, 1.0], rel=0.01)


@pytest.mark.parametrize("lit", [0, 100])
def test_a_picture_that_is_black_nearly_everywhere_has_no_white(lit: int) -> None:
    black, probes = np.zeros((WIDTH * HEIGHT, 3)), np.zeros((9, 3))
    black[:lit], probes[0] = 1.0, lit / 100.0
    white = found(picture_of(black, "cpu"), probes, probes + 1.0, probes + 1.0, np.ones(9))
    assert value(white) == 0.0
    assert white.lit.numpy()[0] == lit


def test_other_pixels_tell_in_other_frames() -> None:
    few = WhitePointParameters(even=500)
    picture = picture_of(np.random.default_rng(3).uniform(size=(WIDTH * HEIGHT, 3)), "cpu")
    probes = np.ones((1, 3))
    seen = [found(picture, probes, probes, probes, np.ones(1), frame, few).quantiles.numpy()[1] for frame in range(40)]
    assert len(set(seen)) > 20
    assert np.mean(seen) == pytest.approx(0.99, abs=0.003)


def test_how_many_pixels_have_light_is_known_to_a_fifth_of_a_percent() -> None:
    """As 65,000 pixels tell it, of which half have light."""
    size = 640, 512
    light = np.random.default_rng(7).integers(0, 2, (size[0] * size[1], 1)) * np.ones(3)
    picture, white = picture_of(light, "cpu", size=size), WhitePoint(len(light), 1, choose_device("cpu"))
    radiance, counts, lit = allocate(ProbeRadiance, 1, choose_device("cpu")), column([1.0], float), []
    for frame in range(24):
        white.find(column([frame], int), picture, counts, radiance)
        lit.append(int(white.lit.numpy()[0]) / white.even)
    assert np.mean(lit) == pytest.approx(0.5, abs=0.002)
    assert 0.0012 < np.std(lit) < 0.002

import numpy as np
import pytest
import warp as wp
from scenes import column
from walls import CPU, HEIGHT, LEFT, WIDTH, wall

from gpu.core.sample_mean import SAMPLES
from gpu.correction.brightness import MeanBrightness
from gpu.gbuffer.shading_points import ShadingPoints

COUNT = WIDTH * HEIGHT


def found(seen: np.ndarray, irradiance: np.ndarray) -> tuple[MeanBrightness, np.ndarray]:
    """What is measured of a white wall where `seen`, and the brightness of its points in their order."""
    gbuffer = wall(seen=seen)
    sps = ShadingPoints((WIDTH, HEIGHT), 1, CPU)
    sps.find(gbuffer)
    measured = MeanBrightness(CPU)
    measured.find(gbuffer, sps, column(irradiance, wp.vec3))
    return measured, irradiance[sps.pixels.numpy()[: sps.count.numpy()[0]]].mean(axis=1) / np.pi


def test_samples_are_the_radiance_of_points_spread_over_the_list() -> None:
    measured, all_points = found(LEFT, np.random.default_rng(1).uniform(0.0, 9.0, (COUNT, 3)))
    count, samples = len(all_points), int(SAMPLES)
    assert count == LEFT.sum()
    assert measured.samples.numpy() == pytest.approx(all_points[np.arange(samples) * count // samples], rel=1e-5)
    assert measured.value.numpy()[0] == pytest.approx(measured.samples.numpy().mean(), rel=1e-5)
    assert measured.value.numpy()[0] == pytest.approx(all_points.mean(), rel=0.03)


def test_a_picture_of_nothing_is_black() -> None:
    measured, _ = found(np.zeros_like(LEFT), np.ones((COUNT, 3)))
    assert not measured.samples.numpy().any()
    assert measured.value.numpy()[0] == 0.0

import numpy as np
import pytest
import warp as wp
from scenes import column
from walls import CPU

from gpu.core.sample_mean import SAMPLES, find_sample_mean


def test_each_mean_is_of_samples_of_its_own() -> None:
    samples = np.random.default_rng(1).uniform(0.0, 9.0, (2, int(SAMPLES))) * [[1.0], [3.0]]
    means = wp.zeros(2, dtype=float, device=CPU)
    find_sample_mean(column(samples.ravel(), float), means)
    assert means.numpy() == pytest.approx(samples.mean(axis=1), rel=1e-6)

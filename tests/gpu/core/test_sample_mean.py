import numpy as np
import pytest
import warp as wp
from scenes import column
from walls import CPU

from gpu.core.sample_mean import SAMPLES, find_sample_mean


def test_the_mean_is_of_all_samples() -> None:
    samples = np.random.default_rng(1).uniform(0.0, 9.0, int(SAMPLES))
    mean = wp.zeros(1, dtype=float, device=CPU)
    find_sample_mean(column(samples, float), mean)
    assert mean.numpy() == pytest.approx(samples.mean(), rel=1e-6)

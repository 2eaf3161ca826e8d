from pathlib import Path

import numpy as np
import pytest

from gpu.settings import Component
from tests.bench.figures import bias_and_noise
from tests.bench.noise import measure_row
from tests.bench.suite import Suite


def test_bias_is_what_renders_have_in_common_and_noise_what_differs() -> None:
    reference = np.ones((40, 50, 3))
    noise = 0.2 * np.random.default_rng(1).standard_normal((2, *reference.shape))
    bias, variance = bias_and_noise(1.1 + noise, reference)
    assert bias == pytest.approx(0.01 / 1.01, rel=0.2)
    assert variance == pytest.approx(0.04 / 1.01, rel=0.1)
    assert bias_and_noise([reference, reference], reference) == (0.0, 0.0)


def test_means_of_a_view_that_rests_are_measured_beside_that_of_many(tmp_path: Path) -> None:
    suite = Suite(out=tmp_path, cache=tmp_path, device="cpu", size=(16, 12), quick=True)
    row = measure_row(suite, "cornell-box", suite.settings(component=Component.INDIRECT))
    assert row["size"] == [16, 12]
    assert [point["frames"] for point in row["points"]] == [1, 2]
    assert 0.0 < row["points"][0]["seconds"] < row["points"][1]["seconds"]
    assert all(point["noise"] > 0.0 and point["errors"]["nonfinite"] == 0 for point in row["points"])

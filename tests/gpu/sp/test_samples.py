"""The sample of SPs that is clustered."""

import numpy as np
import pytest
import warp as wp
from scenes import column
from walking import budget_of

from gpu.core.device import allocate
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.sp.samples import SampledPoints

CPU = wp.get_device("cpu")


def sampled(listed: int, seed: int = 0) -> SampledPoints:
    """Of so many SPs, each at its own number along x, 50 samples for 13 clusters."""
    gbuffer = allocate(GBuffer, 600, CPU)
    gbuffer.position.assign(np.arange(600.0, dtype=np.float32)[:, None] * [1.0, 0.0, 0.0])
    gbuffer.spacing.fill_(1.0)
    points = PointList()
    points.pixels, points.count = column(np.arange(600), wp.int32), column([listed], wp.int32)
    budget = budget_of(13, 1.0)
    budget.spacing_scale.fill_(25**-0.5)
    samples = SampledPoints(13, 4, 50, CPU)
    samples.draw(points, gbuffer, budget, seed)
    return samples


def test_samples_differ_by_seed() -> None:
    first, second, other = (sampled(600, seed).pixels.numpy() for seed in (0, 0, 1))
    assert np.array_equal(first, second)
    assert (first != other).sum() > 25


@pytest.mark.parametrize("listed", [0, 1, 10, 600])
def test_samples_are_even_and_distinct(listed: int) -> None:
    samples = sampled(listed)
    count = samples.points.count.numpy()[0]
    assert count == min(50, listed)
    pixels = samples.pixels.numpy()[:count]
    assert np.array_equal(pixels * count // max(listed, 1), np.arange(count))
    assert np.array_equal(samples.points.position.numpy()[:count, 0], pixels)
    assert samples.points.spacing.numpy()[:count] == pytest.approx((listed / 25) ** 0.5)

import numpy as np
import pytest
from walls import CPU, HEIGHT, WIDTH, grey_values, numbers, wall

from gpu.correction.fireflies import take_fireflies
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.irradiance import allocate_indirect


@pytest.mark.parametrize(("sample", "most"), [(0, 2.0), (8, 3.0), (64, 10.0)])
def test_what_is_far_too_bright_is_taken_out_the_less_the_later(sample: int, most: float) -> None:
    sps = ShadingPoints((WIDTH, HEIGHT), 1, CPU)
    sps.find(wall())
    indirect, light = allocate_indirect(WIDTH * HEIGHT, CPU), np.linspace(0.0, 9.0, WIDTH * HEIGHT)
    indirect.unoccluded_near.fill_(0.1)
    indirect.unoccluded_far.fill_(0.3)
    indirect.irradiance, excess = grey_values(light), grey_values(0.0 * light)
    take_fireflies(sps, sample, indirect, excess)
    kept, taken = numbers(indirect.irradiance), numbers(excess)
    assert np.allclose(kept.ravel(), np.minimum(light, 0.4 * most), atol=1e-5)
    assert np.allclose((kept + taken).ravel(), light, atol=1e-5)

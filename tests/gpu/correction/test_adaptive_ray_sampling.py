import numpy as np
import pytest
from bright import SEEDS, SIZE, Bright, picture_of

from gpu.correction.adaptive_ray_sampling import RAYS
from gpu.correction.adaptive_rays import ADAPTIVE_RAY_PARAMETERS


@pytest.mark.parametrize("far_field_sums", [False, True])
def test_the_mean_of_what_rays_find_is_the_light(far_field_sums: bool) -> None:
    bright = Bright(picture_of(far_field_sums=far_field_sums), SIZE[0] * SIZE[1])
    fuzzy = bright.fuzzy
    assert (fuzzy.view.indirect.unoccluded_far.numpy() > 0.0).any() == far_field_sums
    share = ADAPTIVE_RAY_PARAMETERS.trust
    rays = (fuzzy.unhidden().mean(axis=2) * (fuzzy.seen() - share * fuzzy.shares())).sum(axis=1)
    expected = np.zeros(fuzzy.view.pixels)
    expected[fuzzy.pixels] = share * fuzzy.irradiance()[fuzzy.pixels].mean(axis=1) + rays
    samples = []
    for seed in range(SEEDS):
        pixels = bright.trace(seed)
        samples.append(bright.found()[pixels].mean(axis=1))
    found = np.array(samples)
    assert len(pixels) > 50
    off, error = found.mean(axis=0) - expected[pixels], found.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    assert 0.6 < np.mean((off / error) ** 2) < (2.0 if far_field_sums else 1.5)
    whole = found.sum(axis=1).std(ddof=1) / np.sqrt(SEEDS)
    assert abs(off.sum()) < 4.0 * whole
    assert whole < 0.01 * expected[pixels].sum()


def test_steps_that_are_even_leave_less_noise_than_rays_at_random() -> None:
    bright = Bright(picture_of(far_field_sums=True), SIZE[0] * SIZE[1])
    fuzzy = bright.fuzzy
    pixels = bright.trace()
    found = []
    for seed in range(SEEDS):
        bright.trace(seed)
        found.append(bright.found()[pixels].mean(axis=1))
    amount, wrong = fuzzy.unhidden().mean(axis=2), fuzzy.seen() - ADAPTIVE_RAY_PARAMETERS.trust * fuzzy.shares()
    random = ((amount.sum(axis=1) * (amount * wrong**2).sum(axis=1)) - (amount * wrong).sum(axis=1) ** 2) / RAYS
    rows = np.argsort(fuzzy.pixels)[np.searchsorted(np.sort(fuzzy.pixels), pixels)]
    assert np.var(found, axis=0, ddof=1).mean() < 0.8 * random[rows].mean()

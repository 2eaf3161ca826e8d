import numpy as np
import pytest
from pipeline import Pipeline, relative_error
from scenes import slats

from gpu.indirect.irradiance import CHECKS
from gpu.scene.types import Doubles

SEEDS = 300


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    device_scene, camera, size = slats((24, 18))
    return Pipeline(device_scene, camera, size, sp_clusters=60)


def drawn(fuzzy: Pipeline) -> Doubles:
    """The targets of every SP by SEEDS seeds, (seed, check, sp)."""
    targets = []
    for seed in range(SEEDS):
        fuzzy.shade(seed)
        targets.append(fuzzy.view.indirect.target.numpy()[:, : fuzzy.sp_count].copy())
    fuzzy.shade()
    return np.stack(targets)


def deviations_of_chi_squared(targets: Doubles, weights: Doubles) -> float:
    """How far Pearson's χ², summed over SPs, is from its mean, in its deviations.

    targets (draw, sp) of the distribution of weights (sp, target); few-fold targets of an SP count as one.
    """
    total, freedom, variance = 0.0, 0, 0.0
    for sp in np.flatnonzero(weights.sum(axis=1) > 0.0):
        expected = len(targets) * weights[sp] / weights[sp].sum()
        counts = np.bincount(targets[:, sp], minlength=len(expected))
        often = expected >= 5.0
        rest = expected[~often].sum()
        values, numbers = expected[often], counts[often]
        if rest >= 5.0:
            values, numbers = np.append(values, rest), np.append(numbers, counts[~often].sum())
        total += float(((numbers - values) ** 2 / values).sum())
        freedom += len(values) - (1 if rest >= 5.0 or rest == 0.0 else 0)
        variance += 2.0 * len(values)
    return (total - freedom) / np.sqrt(variance)


def test_irradiance_is_the_weighted_sum_over_the_clusters_of_an_sp(fuzzy: Pipeline) -> None:
    shares = fuzzy.shares()
    expected = np.einsum("sv,svc->sc", shares, fuzzy.unhidden())
    assert expected.max() > 0.0
    assert np.allclose(fuzzy.irradiance()[fuzzy.pixels], expected, rtol=1e-3, atol=1e-6 * expected.max())
    assert ((shares > 0.01) & (shares < 0.99)).any()  # some clusters disagree, or the above says little


def in_doubt(fuzzy: Pipeline) -> Doubles:
    """Light of each VPL cluster at each SP times the visibility_weight about its visibility, (sp, VPL cluster)."""
    return fuzzy.unhidden().mean(axis=2) * fuzzy.doubts()


def test_the_light_in_doubt_is_told(fuzzy: Pipeline) -> None:
    expected = in_doubt(fuzzy).sum(axis=1)
    assert (expected > 0.0).any()
    assert fuzzy.view.indirect.near_importance.numpy()[: fuzzy.sp_count] == pytest.approx(expected, rel=1e-3)
    assert not fuzzy.view.indirect.far_importance.numpy().any()


def test_targets_are_drawn_in_proportion_to_their_light_in_doubt(fuzzy: Pipeline) -> None:
    targets, doubted = drawn(fuzzy), in_doubt(fuzzy)
    assert targets.shape[1] == CHECKS > 1
    assert ((targets >= 0) == (doubted.sum(axis=1) > 0.0)).all()
    assert abs(deviations_of_chi_squared(targets.reshape(-1, fuzzy.sp_count), doubted)) < 4.0
    # The test is sharp enough to tell other weights: those without the visibility_weight.
    wrong = fuzzy.unhidden().mean(axis=2)
    assert deviations_of_chi_squared(targets.reshape(-1, fuzzy.sp_count), wrong) > 10.0


def test_checks_of_an_sp_are_drawn_independently(fuzzy: Pipeline) -> None:
    targets, doubted = drawn(fuzzy)[:, :2], in_doubt(fuzzy)
    lit = doubted.sum(axis=1) > 0.0
    chances = doubted[lit] / doubted[lit].sum(axis=1, keepdims=True)
    expected = (chances**2).sum(axis=1)
    same = (targets[:, 0] == targets[:, 1])[:, lit]
    error = np.sqrt((expected * (1.0 - expected)).sum() / SEEDS)
    assert abs((same.mean(axis=0) - expected).sum()) < 4.0 * error


def test_far_light_of_representatives_is_near_that_of_each_pair(fuzzy: Pipeline) -> None:
    summed = Pipeline(fuzzy.device_scene, fuzzy.camera, (48, 36), sp_clusters=400, far_field_sums=True)
    one_by_one = Pipeline(fuzzy.device_scene, fuzzy.camera, (48, 36), sp_clusters=400)
    near = summed.view.indirect.pairs.numpy().sum()
    assert 0 < near < 0.3 * one_by_one.view.indirect.pairs.numpy().sum()
    assert one_by_one.view.indirect.pairs.numpy().sum() == summed.sp_count * summed.lights.count
    expected = one_by_one.irradiance()
    assert relative_error(summed.irradiance(), expected) < 2e-3
    assert summed.irradiance().mean() == pytest.approx(expected.mean(), rel=0.01)

from itertools import product

import numpy as np
import pytest
from pipeline import Pipeline, relative_error
from scenes import slats

from gpu.scene.types import Doubles
from gpu.shade import CHECKS, HIDDEN_CHECK, HIDDEN_WORDS

SEEDS = 300


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    resident, camera, size = slats((24, 18))
    return Pipeline(resident, camera, size, sp_clusters=60)


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


def in_doubt(fuzzy: Pipeline) -> tuple[Doubles, Doubles]:
    """Light of each VPL cluster at each SP that is in doubt, and that is hidden by all beliefs, (sp, VPL cluster)."""
    amount, shares = fuzzy.unhidden().mean(axis=2), fuzzy.shares()
    return amount * fuzzy.doubts() * (shares > 0.0), amount * (shares == 0.0)


def test_the_light_in_doubt_and_the_hidden_light_are_told(fuzzy: Pipeline) -> None:
    for told, expected in zip((fuzzy.view.indirect.doubted, fuzzy.view.indirect.hidden), in_doubt(fuzzy), strict=True):
        assert (expected.sum(axis=1) > 0.0).any()
        assert told.numpy()[: fuzzy.sp_count] == pytest.approx(expected.sum(axis=1), rel=1e-3)


def test_targets_are_drawn_in_proportion_to_their_light_in_doubt(fuzzy: Pipeline) -> None:
    targets, (doubted, hidden) = drawn(fuzzy), in_doubt(fuzzy)
    assert targets.shape[1] == CHECKS > 1
    some = targets[:, :HIDDEN_CHECK]
    assert ((some >= 0) == (doubted.sum(axis=1) > 0.0)).all()
    assert ((targets[:, HIDDEN_CHECK] >= 0) == (hidden.sum(axis=1) > 0.0)).all()
    assert abs(deviations_of_chi_squared(some.reshape(-1, fuzzy.sp_count), doubted)) < 4.0
    assert abs(deviations_of_chi_squared(targets[:, HIDDEN_CHECK], hidden)) < 4.0
    # The test is sharp enough to tell other weights: those without the doubt.
    wrong = fuzzy.unhidden().mean(axis=2) * (doubted > 0.0)
    assert deviations_of_chi_squared(some.reshape(-1, fuzzy.sp_count), wrong) > 10.0


def test_checks_of_an_sp_are_drawn_independently(fuzzy: Pipeline) -> None:
    targets, (doubted, _) = drawn(fuzzy)[:, :2], in_doubt(fuzzy)[:2]
    lit = doubted.sum(axis=1) > 0.0
    chances = doubted[lit] / doubted[lit].sum(axis=1, keepdims=True)
    expected = (chances**2).sum(axis=1)
    same = (targets[:, 0] == targets[:, 1])[:, lit]
    error = np.sqrt((expected * (1.0 - expected)).sum() / SEEDS)
    assert abs((same.mean(axis=0) - expected).sum()) < 4.0 * error


def test_targets_know_what_the_clusters_believe_of_them(fuzzy: Pipeline) -> None:
    indirect, count = fuzzy.view.indirect, fuzzy.sp_count
    target, believed = indirect.target.numpy()[:, :count], indirect.believed.numpy()[:, :count]
    expected = fuzzy.shares()[np.arange(count)[None], target]
    drawn = target >= 0
    assert believed[drawn] == pytest.approx(expected[drawn], abs=1e-5)


def test_gather_and_shade_agree_when_every_sp_is_a_cluster_of_its_own(fuzzy: Pipeline) -> None:
    own = Pipeline(fuzzy.resident, fuzzy.camera, fuzzy.size, sp_clusters=60, fuzziness=1)
    exact = own.exact()
    assert relative_error(own.irradiance(), exact) > 1e-3
    own.know_the_truth()
    assert np.allclose(own.irradiance(), exact, rtol=1e-3, atol=1e-5 * exact.max())


def test_runs_of_vpl_clusters_add_up(fuzzy: Pipeline) -> None:
    middle = fuzzy.lights.count // 2
    one, other = fuzzy.gathered(fuzzy.lights, 0, middle), fuzzy.gathered(fuzzy.lights, middle)
    assert one.sum() > 0.0
    assert other.sum() > 0.0
    assert np.allclose(one + other, fuzzy.exact(), rtol=1e-5)


def test_light_of_what_no_cluster_sees_is_all_hidden_in_the_mean_of_words_that_stand_for_others(
    fuzzy: Pipeline,
) -> None:
    blind = Pipeline(fuzzy.resident, fuzzy.camera, (16, 12), sp_clusters=20, vpl_clusters=250)
    blind.believe(np.zeros((blind.clustering.count, blind.lights.count)))
    words = np.add.reduceat(blind.unhidden().mean(axis=2), np.arange(0, blind.lights.count, 32), axis=1)
    totals = []
    for seed in range(SEEDS):
        blind.shade(seed)
        assert (blind.irradiance() == 0.0).all()
        assert (blind.view.indirect.doubted.numpy() == 0.0).all()
        totals.append(blind.view.indirect.hidden.numpy()[: blind.sp_count].astype(np.float64))
    expected, times = words.sum(axis=1), int(HIDDEN_WORDS)
    error = np.sqrt((times - 1) * (words**2).sum(axis=1) / SEEDS)
    deviations = (np.mean(totals, axis=0) - expected) / error
    assert np.abs(deviations).max() < 4.0
    # A word counts not at all, or for as many as it stands for.
    choices = np.array(list(product((0, times), repeat=words.shape[1])))
    off = np.abs(words @ choices.T - totals[0][:, None]).min(axis=1)
    assert (off < 1e-4 * expected).all()

import numpy as np
import pytest

from gpu.adaptive.error_model import ErrorModel, ErrorModelParameters, Estimate
from gpu.adaptive.levels import Level

PARAMETERS = ErrorModelParameters()
USUAL, TWICE = Level(4000, 1000), Level(8000, 2000)


def test_the_first_estimate_is_what_is_expected_next() -> None:
    model = ErrorModel()
    model.observe(USUAL, Estimate(1e-3, 1e-4))
    assert model.predict(USUAL) == pytest.approx(1e-3)
    assert model.predict(TWICE) == pytest.approx(1e-3 * 2.0**-PARAMETERS.vpl_power)
    assert not model.ready


def test_light_that_comes_back_has_its_error() -> None:
    model = ErrorModel()
    for lit in [1.0] * 20 + [0.0] * 3 + [1.0] * 2:
        model.observe(USUAL, Estimate(1e-3 * lit, 1e-5 * lit, lit))
    assert model.predict(USUAL) == pytest.approx(1e-3, rel=0.3)


def test_it_goes_on_as_a_view_changes() -> None:
    """Each frame 4 percent more; a mean of some frames would lag by half their number."""
    model = ErrorModel()
    for number in range(40):
        model.observe(USUAL, Estimate(1e-3 * 1.04**number, 2e-5 * 1.04**number))
    assert model.predict(USUAL) == pytest.approx(1e-3 * 1.04**40, rel=0.02)


def test_a_view_that_is_rendered_again_has_not_gone_on() -> None:
    """Each view 8 percent harder, with 3 percent more light."""
    model = ErrorModel()
    for number in range(40):
        model.observe(USUAL, Estimate(1e-3 * 1.08**number, 2e-5 * 1.08**number, 0.2 * 1.03**number))
    last, following = 1e-3 * 1.08**39, model.predict(USUAL)
    assert following == pytest.approx(1.08 * last, rel=0.05)
    model.hold_view()
    assert model.predict(USUAL) == pytest.approx(last, rel=0.01)
    model.observe(TWICE, Estimate(last * 2.0**-PARAMETERS.vpl_power, 2e-2 * last, 0.2 * 1.03**39))
    assert model.predict(USUAL) == pytest.approx(1.08 * last, rel=0.05)


def misses_of(swings: float, noise: float) -> float:
    """Deviation of the logarithms of what is expected, where hardness swings so far to either side in 24 frames."""
    random, model, misses = np.random.default_rng(6), ErrorModel(), []
    for number in range(200):
        error = 1e-3 * np.exp(swings * np.sin(2.0 * np.pi * number / 24.0))
        if number > 20:
            misses.append(np.log(model.predict(USUAL) / error))
        model.observe(USUAL, Estimate(error * (1.0 + noise * random.standard_normal()), noise * error))
    return float(np.std(misses))


def test_a_restless_view_is_followed_faster_than_noise() -> None:
    assert misses_of(0.4, 0.06) < 0.17
    assert misses_of(0.0, 0.1) < 0.07


def test_noisy_estimates_move_it_less() -> None:
    after = []
    for noise in (0.02, 0.3):
        model = ErrorModel()
        for _ in range(30):
            model.observe(USUAL, Estimate(1e-3, noise * 1e-3))
        assert model.ready
        model.observe(USUAL, Estimate(1.3e-3, noise * 1.3e-3))
        after.append(model.predict(USUAL))
    assert after[0] > 1.15e-3
    assert after[1] < 1.03e-3


def test_nothing_unsound_comes_of_estimates_of_nothing() -> None:
    """As of a black picture, for long, and then of light."""
    model = ErrorModel()
    for number in range(3000):
        model.observe(TWICE if number % 7 else USUAL, Estimate(-1e-3 if number % 5 == 0 else 0.0, 0.0))
        assert 0.0 < model.predict(USUAL) < 1.0
    for _ in range(200):
        model.observe(USUAL, Estimate(1e-3, 1e-4))
    assert model.predict(USUAL) == pytest.approx(1e-3, rel=0.05)


@pytest.mark.parametrize("error", [np.nan, np.inf])
def test_what_is_not_finite_tells_nothing(error: float) -> None:
    model = ErrorModel()
    for estimate in (Estimate(error, 1.0), Estimate(1e-3, 1e-4), Estimate(error, error), Estimate(1e-3, np.nan)):
        model.observe(USUAL, estimate)
    assert model.predict(USUAL) == pytest.approx(1e-3)


def test_few_sp_clusters_do_more_harm_than_many_do_good() -> None:
    """As the mean of three scenes: 1.3, 1.4 and 1.8 times the error of a sixth; 0.92, 0.97, 0.71 of six times more."""
    model = ErrorModel()
    model.observe(USUAL, Estimate(1e-3, 1e-5))
    assert model.predict(Level(667, 1000)) == pytest.approx(1.5e-3, rel=0.04)
    assert model.predict(Level(24_000, 1000)) == pytest.approx(0.87e-3, rel=0.03)
    assert 3e-3 < model.predict(Level(100, 1000)) < 4e-3  # as few as there are for a wanted error


def test_one_estimate_far_off_moves_it_by_so_much_at_the_most() -> None:
    model = ErrorModel()
    for error in [1e-3] * 30 + [1e-1]:
        model.observe(USUAL, Estimate(error, 1e-6))
    assert 2.5e-3 < model.predict(USUAL) < 3.5e-3


def test_one_harder_view_makes_no_trend() -> None:
    """A fifth harder than thirty before: what comes next is not taken to be a quarter harder."""
    model = ErrorModel()
    for error in [1e-3] * 30 + [1.2e-3]:
        model.observe(USUAL, Estimate(error, 1e-5))
    assert 1.2e-3 < model.predict(USUAL) < 1.25e-3


def test_a_black_frame_leaves_the_next_one_few_pixels_with_light() -> None:
    model = ErrorModel()
    model.observe(USUAL, Estimate(1e-3, 1e-5))
    model.observe(USUAL, Estimate(0.0, 0.0, 0.0))
    assert model.predict(USUAL) == pytest.approx(1e-7)


@pytest.mark.parametrize(("true", "least", "most"), [(0.5, 0.22, 0.26), (3.0, 0.35, 0.41), (0.0, 0.09, 0.1)])
def test_another_try_tells_how_much_sp_clusters_help(true: float, least: float, most: float) -> None:
    """Twice as many leave an error that is less by a power of about `true`; powers are within bounds."""
    model, more = ErrorModel(), Level(8000, 1000)
    for _ in range(30):
        model.observe(USUAL, Estimate(1e-3, 1e-5))
    model.hold_view()
    basis = model._sp_basis(USUAL) - model._sp_basis(more)
    model.observe(more, Estimate(1e-3 * np.exp(-true * basis), 1e-5))
    assert least < model._sp_power < most

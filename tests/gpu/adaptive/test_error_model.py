import numpy as np
import pytest

from gpu.adaptive.error_model import LEAST_POWER, MOST_LUCK, POWERS, ErrorModel, Estimate
from gpu.adaptive.levels import Level

USUAL, TWICE = Level(4000, 1000), Level(8000, 2000)


def measured(level: Level) -> float:
    """Errors as counts left them in a Cornell box, 1e-3 of the usual ones."""
    ratio = level.sp_clusters / (4.0 * level.vpl_clusters)
    return 1e-3 * (1.0 + 0.12 * ratio**-0.8) / 1.12 * (level.vpl_clusters / 1000) ** -0.4


def test_the_first_estimate_is_what_is_expected_next() -> None:
    model = ErrorModel()
    model.observe(USUAL, Estimate(1e-3, 1e-4))
    assert model.predict(USUAL) == pytest.approx(1e-3)
    assert model.predict(TWICE) == pytest.approx(1e-3 * 2.0 ** -POWERS[1])
    assert not model.ready


def test_it_learns_how_much_counts_help() -> None:
    model = ErrorModel()
    for number in range(40):
        level = TWICE if number % 4 >= 2 else USUAL
        model.observe(level, Estimate(1e-3 * (level.vpl_clusters / 1000) ** -0.9, 2e-5))
    assert model.predict(TWICE) / model.predict(USUAL) == pytest.approx(2.0**-0.9, rel=0.03)


def test_it_learns_apart_what_sp_and_vpl_clusters_help() -> None:
    """In a Cornell box SP clusters help little, VPL clusters much."""
    model = ErrorModel()
    levels = [USUAL, Level(16_000, 1000), Level(4000, 2000), TWICE]
    for number in range(80):
        level = levels[number // 2 % 4]
        model.observe(level, Estimate(measured(level), 2e-5))
    for level in levels[1:]:
        assert model.predict(level) / model.predict(USUAL) == pytest.approx(measured(level) / measured(USUAL), rel=0.03)


def test_few_sp_clusters_are_known_to_do_more_harm_than_many_do_good() -> None:
    """By what few more and few less told: a mere power of them would be off by 12 percent."""
    model = ErrorModel()
    levels = [USUAL, Level(6000, 1000), Level(2700, 1000)]
    for number in range(60):
        level = levels[number // 2 % 3]
        model.observe(level, Estimate(measured(level), 1e-5))
    for level in (Level(400, 1000), Level(40_000, 1000)):
        assert model.predict(level) == pytest.approx(measured(level), rel=0.05)


def test_a_light_set_that_is_lucky_is_known_when_it_comes_again() -> None:
    """Where 1000 VPL clusters happen to leave a fifth less error than 800 and 1250 tell."""
    model, levels = ErrorModel(), [Level(4000, number) for number in (800, 1000, 1250)]

    def error(level: Level) -> float:
        return 1e-3 * (level.vpl_clusters / 1000) ** -0.4 * (0.8 if level.vpl_clusters == 1000 else 1.0)

    for number in range(60):
        model.observe(levels[number // 10 % 3], Estimate(error(levels[number // 10 % 3]), 3e-5))
    for level in levels:
        assert model.predict(level) == pytest.approx(error(level), rel=0.02)


def test_pixels_without_light_have_no_error() -> None:
    """Frames whose pixels lose and get their light fast have errors as expected: that is known without noise."""
    model, random = ErrorModel(), np.random.default_rng(4)
    share, misses = [0.6 + 0.3 * np.sin(number / 5.0) for number in range(101)], []
    for number in range(100):
        error = 1e-3 * share[number]
        if number > 20:
            misses.append(model.predict(USUAL) / error - 1.0)
        heard = error * (1.0 + 0.1 * random.standard_normal())
        model.observe(USUAL, Estimate(heard, 0.1 * error, share[number]))
    assert np.std(misses) < 0.06
    assert abs(np.mean(misses)) < 0.03


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
    assert following == pytest.approx(1.08 * last, rel=0.02)
    model.stay()
    assert model.predict(USUAL) == pytest.approx(last, rel=0.01)
    model.leave()
    assert model.predict(USUAL) == following
    model.stay()
    model.observe(TWICE, Estimate(last * 2.0 ** -POWERS[1], 2e-2 * last, 0.2 * 1.03**39))
    assert model.predict(USUAL) == pytest.approx(1.08 * last, rel=0.02)


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
    assert misses_of(0.4, 0.06) < 0.13
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
    assert after[1] < 1.08e-3


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


def test_more_sp_clusters_are_never_taken_to_do_harm() -> None:
    """Where the views with more of them happen to be harder."""
    model, more = ErrorModel(), Level(16_000, 1000)
    for number in range(60):
        level = more if number % 4 >= 2 else USUAL
        model.observe(level, Estimate(1e-3 * (level.sp_clusters / 4000) ** 0.5, 2e-5))
    assert model.predict(more) < model.predict(USUAL)


def test_luck_has_its_bounds() -> None:
    model = ErrorModel()
    for number in range(60):
        level = TWICE if number % 4 >= 2 else USUAL
        model.observe(level, Estimate(1e-3 * (level.vpl_clusters / 1000) ** 2.0, 2e-5))
    assert model.predict(TWICE) / model.predict(USUAL) <= 1.0001 * 2.0**-LEAST_POWER * np.exp(2.0 * MOST_LUCK)

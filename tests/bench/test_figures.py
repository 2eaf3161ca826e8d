import numpy as np
import pytest

from gpu.film.metrics import rel_mse
from tests.bench.figures import error_beyond_noise, flicker, front, slope, spread, tell_apart, time_to_equal_error


def test_spread_is_the_median_and_the_percentiles_not_the_best() -> None:
    assert spread(np.arange(101.0)) == {"median": 50.0, "p5": 5.0, "p95": 95.0}


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_slope_is_the_power(power: float) -> None:
    x = np.array([1e3, 1e4, 1e6])
    assert slope(x, 3.0 * x**power) == pytest.approx(power)


def test_one_size_has_no_slope() -> None:
    assert np.isnan(slope([10.0, 10.0], [1.0, 2.0]))


def test_equal_error_lies_on_the_power_law_between_measurements() -> None:
    points = [(time, 1.0 / time) for time in (1.0, 4.0, 16.0, 64.0)]
    assert time_to_equal_error(points, 1.0 / 10.0) == pytest.approx(10.0)
    assert time_to_equal_error(points[::-1], 1.0) == pytest.approx(1.0)


@pytest.mark.parametrize("wanted", [2.0, 0.001])
def test_equal_error_is_not_guessed_beyond_what_was_measured(wanted: float) -> None:
    assert time_to_equal_error([(1.0, 1.0), (4.0, 0.25)], wanted) is None


def test_the_front_has_no_point_that_another_beats() -> None:
    assert front([(3.0, 1.0), (1.0, 5.0), (2.0, 6.0), (4.0, 1.0)]) == [(1.0, 5.0), (3.0, 1.0)]


def test_what_changes_as_the_reference_does_is_no_flicker() -> None:
    walk = np.random.default_rng(0).random((5, 4, 6, 3))
    same = flicker(walk, walk)
    assert same.flicker == same.error_change == 0.0
    assert same.change == same.reference_change > 0.0


def test_flicker_is_the_change_beyond_the_references_own() -> None:
    references = np.full((3, 2, 2, 3), 2.0)
    references[1] += 0.5
    renders = references.copy()
    renders[1] += 1.0
    result = flicker(renders, references)
    mean = references.mean()
    assert result.change == pytest.approx(1.5 / mean)
    assert result.reference_change == pytest.approx(0.5 / mean)
    assert result.flicker == pytest.approx(1.0 / mean)


def test_change_in_the_wrong_place_is_seen_by_the_change_of_error() -> None:
    references, renders = np.zeros((2, 1, 2, 3)), np.zeros((2, 1, 2, 3))
    references[1, 0, 0], renders[1, 0, 1] = 1.0, 1.0
    result = flicker(renders, references)
    assert result.flicker == 0.0
    assert result.error_change > 0.0


def test_flicker_needs_two_frames() -> None:
    with pytest.raises(ValueError, match="two frames"):
        flicker(np.zeros((1, 2, 2, 3)), np.zeros((1, 2, 2, 3)))


def test_errors_told_apart_are_what_was_put_in() -> None:
    generator = np.random.default_rng(1)
    shape = (60, 60, 3)
    reference = np.ones(shape)
    exact = [reference + 0.3 + 0.2 * generator.standard_normal(shape) for _ in range(4)]
    clustered = [image + 0.1 * np.where(np.arange(60) % 2, 1, -1)[:, None, None] for image in exact]
    clustered = [image + 0.05 * generator.standard_normal(shape) for image in clustered]
    parts = tell_apart(clustered, exact, reference)
    unit = 1.0 / 1.01
    assert parts.vpl_bias == pytest.approx(0.09 * unit, rel=0.1)
    assert parts.vpl_noise == pytest.approx(0.04 * unit, rel=0.1)
    assert parts.clustering_bias == pytest.approx(0.01 * unit, rel=0.1)
    assert parts.clustering_noise == pytest.approx(0.0025 * unit, rel=0.1)
    total = np.mean([rel_mse(image, reference) for image in clustered])
    assert parts.total_bias + parts.total_noise == pytest.approx(total)


def test_error_beyond_noise_is_that_against_the_truth() -> None:
    generator = np.random.default_rng(2)
    truth = 1.0 + generator.random((200, 200, 3))
    render = truth + 0.05 * generator.standard_normal(truth.shape)
    pictures = [truth + 0.15 * generator.standard_normal(truth.shape) for _ in range(2)]
    wanted = rel_mse(render, truth)
    assert rel_mse(render, pictures[0]) > 5.0 * wanted
    assert error_beyond_noise(render, *pictures) == pytest.approx(wanted, rel=0.15)


def test_the_references_noise_is_no_bias_of_the_vpls() -> None:
    reference = np.ones((8, 8, 3))
    renders = [reference + 0.1, reference + 0.1]
    plain, less = tell_apart(renders, renders, reference), tell_apart(renders, renders, reference, 0.004)
    assert less.vpl_bias == pytest.approx(plain.vpl_bias - 0.004)
    assert less.total_bias == pytest.approx(plain.total_bias - 0.004)
    assert less.total_noise == plain.total_noise

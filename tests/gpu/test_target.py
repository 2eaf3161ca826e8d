"""The choice of counts against simulated renderers: what times and errors do is known there."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from gpu.target import MOST, MOST_WORK, STEP, ErrorModel, Governor, TimeModel, ladder

PIXELS = 600_000
USUAL = 2.0**24  # work of the default counts of a GPU
FEW = 10  # frames that a target may take to be met


def milliseconds(work: float, fixed: float = 3.0, rate: float = 7.0) -> float:
    return fixed + rate * work / USUAL


def walk(
    target: float,
    plant: Callable[[int, float], float],
    frames: int,
    noise: float = 0.02,
    outliers: tuple[int, ...] = (),
) -> tuple[np.ndarray, np.ndarray]:
    """Times of a walk's frames over the target, and their work; the governor hears them with noise, some threefold."""
    random, governor = np.random.default_rng(5), Governor(ladder(PIXELS), TimeModel(), target, USUAL)
    times, works = [], []
    for number in range(frames):
        works.append(governor.level.work)
        times.append(plant(number, works[-1]))
        heard = times[-1] * (1.0 + noise * random.standard_normal())
        governor.learn(3.0 * heard if number in outliers else heard)
    return np.array(times) / target, np.array(works)


def moves(works: np.ndarray) -> int:
    return int(np.count_nonzero(np.diff(works)))


def test_levels_go_from_little_to_the_most_in_equal_steps() -> None:
    levels = ladder(PIXELS)
    steps = np.array([above.work / below.work for below, above in pairwise(levels)])
    assert np.all(np.abs(steps / STEP - 1.0) < 0.02)
    assert levels[0].work < 1e-3 * USUAL
    assert levels[-1].work == pytest.approx(MOST_WORK, rel=STEP - 1.0)
    assert max(level.sp_clusters for level in levels) <= MOST.sp_clusters
    assert max(level.vpl_clusters for level in levels) == MOST.vpl_clusters
    assert len({level.vpl_clusters for level in levels}) < 20
    assert any(0.9 < level.sp_clusters / 8192 < 1.1 and level.vpl_clusters == 2048 for level in levels)


@pytest.mark.parametrize("pixels", [1, 100, 5000])
def test_small_images_have_no_more_clusters_than_pixels(pixels: int) -> None:
    levels = ladder(pixels)
    assert all(1 <= level.sp_clusters <= pixels for level in levels)
    assert all(below.work < above.work for below, above in pairwise(levels))


def test_wanted_vpls_are_not_split_into_clusters_of_few() -> None:
    levels = ladder(PIXELS, 8000)
    assert max(level.vpls for level in levels) <= 8000
    assert max(level.sp_clusters for level in levels) == MOST.sp_clusters
    assert {level.vpl_clusters for level in ladder(PIXELS, 1)} == {32}


@pytest.mark.parametrize("target", [4.0, 6.0, 9.0, 30.0, 100.0])
def test_a_time_is_met_within_few_frames_and_held(target: float) -> None:
    times, works = walk(target, lambda _, work: milliseconds(work), 60)
    assert np.all(np.abs(times[FEW:] - 1.0) < 0.1)
    assert moves(works[FEW:]) < 10


def test_without_noise_a_level_is_kept() -> None:
    _, works = walk(8.0, lambda _, work: milliseconds(work), 60, noise=0.0)
    assert moves(works[FEW:]) == 0


def test_a_step_of_the_cost_is_followed() -> None:
    times, _ = walk(12.0, lambda number, work: milliseconds(work) * (2.0 if number >= 30 else 1.0), 60)
    assert np.all(np.abs(times[30 + FEW :] - 1.0) < 0.1)


def test_a_slow_change_of_the_cost_is_followed() -> None:
    times, works = walk(12.0, lambda number, work: milliseconds(work) * (1.0 + 0.5 * np.sin(number / 20.0)), 250)
    assert np.mean(np.abs(times[FEW:] - 1.0) < 0.1) > 0.97
    assert moves(works) < 100


def test_a_time_that_does_not_repeat_is_ignored() -> None:
    _, works = walk(12.0, lambda _, work: milliseconds(work), 60, noise=0.0, outliers=(20, 30, 40, 50))
    assert moves(works[FEW:]) == 0


@pytest.mark.parametrize(("target", "end"), [(1.0, 0), (1e4, -1)])
def test_what_cannot_be_met_ends_at_the_end_of_the_levels(target: float, end: int) -> None:
    _, works = walk(target, lambda _, work: milliseconds(work), 60)
    assert works[-1] == ladder(PIXELS)[end].work
    assert moves(works[20:]) == 0


def test_work_grows_fourfold_at_most_from_one_frame_to_the_next() -> None:
    _, works = walk(1e4, lambda _, work: milliseconds(work), 10)
    assert np.all(works[1:] / works[:-1] < 4.0 * STEP)


@pytest.mark.parametrize(("target", "power"), [(2e-4, 0.4), (5e-4, 0.7), (3e-3, 0.4), (1e-3, 0.25)])
def test_a_noisy_error_is_met_in_the_mean(target: float, power: float) -> None:
    means = []
    for seed in range(8):
        random, governor = np.random.default_rng(seed), Governor(ladder(PIXELS), ErrorModel(), target, USUAL)
        errors = []
        for _ in range(200):
            errors.append(1e-3 * (governor.level.work / USUAL) ** -power)
            governor.learn(errors[-1] * random.gamma(4.0, 0.25))
        means.append(np.mean(errors[64:]) / target)
    assert abs(np.mean(means) - 1.0) < 0.05
    assert max(abs(mean - 1.0) for mean in means) < 0.25


def test_estimates_below_zero_count_as_no_error() -> None:
    governor = Governor(ladder(PIXELS), ErrorModel(), 1e-3, USUAL)
    for _ in range(20):
        governor.learn(-1e-4)
    assert governor.level == ladder(PIXELS)[0]


def test_a_first_picture_waits_until_the_level_stays() -> None:
    governor = Governor(ladder(PIXELS), TimeModel(), 30.0, USUAL)
    waited = [governor.learn(milliseconds(governor.level.work)) for _ in range(6)]
    assert not waited[0]
    assert waited[-1]
    assert governor.expected == pytest.approx(milliseconds(governor.level.work), rel=0.05)
    assert governor.expected == pytest.approx(30.0, rel=0.1)

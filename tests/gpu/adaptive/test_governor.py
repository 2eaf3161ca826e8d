"""The choice of counts against simulated renderers: what times and errors do is known there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import log

import numpy as np
import pytest

from gpu.adaptive.error_model import Estimate
from gpu.adaptive.governor import FOR_WALK, ErrorGovernor, ErrorGovernorParameters, Governor, GovernorParameters
from gpu.adaptive.levels import FOR_TIME, MOST, Level, Levels, levels_of
from gpu.adaptive.time_model import TimeModel

PIXELS = 600_000
USUAL = Level(8192, 2048)
FEW = 10  # frames that a target may take to be met

Stages = dict[str, float]


def milliseconds(level: Level) -> Stages:
    """Times of a conference room's stages; their powers are not those of the model."""
    sps, vpls = level.sp_clusters / USUAL.sp_clusters, level.vpl_clusters / USUAL.vpl_clusters
    return {
        "fixed": 1.4,
        "correct": 0.6 * level.passes**0.75,
        "cluster": 0.6 + 0.6 * sps**0.4,
        "visibility": 0.3 + 2.0 * sps * vpls,
        "shade": 0.3 + (1.6 + 1.4 * sps**0.8) * vpls,
        "refine": 1.2 * min(sps, 4.0) ** 0.6,
    }


def for_time(target: float, parameters: GovernorParameters | None = None) -> Governor[Mapping[str, float]]:
    """One that starts at about the usual counts."""
    levels = Levels(PIXELS, parameters=FOR_TIME)
    return Governor(levels, TimeModel(), target, levels.nearest(USUAL.work), parameters)


def scaled(times: Stages, factor: float) -> Stages:
    return {name: factor * value for name, value in times.items()}


def walk(
    target: float,
    plant: Callable[[int, Level], Stages],
    frames: int,
    noise: float = 0.02,
    outliers: tuple[int, ...] = (),
) -> tuple[np.ndarray, list[Level]]:
    """Times of a walk's frames over the target, and their levels; the governor hears noisy ones, some threefold."""
    random, governor = np.random.default_rng(5), for_time(target)
    times, levels = [], []
    for number in range(frames):
        levels.append(governor.level)
        parts = plant(number, governor.level)
        times.append(sum(parts.values()))
        heard = scaled(parts, 1.0 + noise * random.standard_normal())
        governor.learn(scaled(heard, 3.0) if number in outliers else heard, anew=number < FEW)
    return np.array(times) / target, levels


def moves(levels: list[Level]) -> int:
    return sum(before != after for before, after in pairwise(levels))


def light_sets(levels: list[Level]) -> int:
    return sum(before.vpl_clusters != after.vpl_clusters for before, after in pairwise(levels))


def within_each(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.abs(values - 1.0) < 0.1)


def within(values: np.ndarray) -> float:
    return float(np.mean(within_each(values)))


@pytest.mark.parametrize("target", [5.0, 6.0, 9.0, 30.0, 100.0])
def test_a_time_is_met_within_few_frames_and_held(target: float) -> None:
    times, levels = walk(target, lambda _, level: milliseconds(level), 60)
    assert within(times[FEW:]) == 1.0
    assert moves(levels[FEW:]) < 10
    assert light_sets(levels[FEW:]) == 0


def test_without_noise_a_level_is_kept() -> None:
    _, levels = walk(8.0, lambda _, level: milliseconds(level), 60, noise=0.0)
    assert moves(levels[FEW:]) == 0


def test_a_step_of_the_cost_is_followed_by_sp_clusters_at_once() -> None:
    def plant(number: int, level: Level) -> Stages:
        return scaled(milliseconds(level), 1.25 if number >= 30 else 1.0)

    times, levels = walk(12.0, plant, 60, noise=0.0)
    assert within(times[33:]) == 1.0
    assert light_sets(levels[FEW:]) == 0


def test_a_much_larger_cost_is_believed_when_it_comes_again() -> None:
    times, levels = walk(12.0, lambda number, level: scaled(milliseconds(level), 1.7 if number >= 30 else 1.0), 60)
    assert not np.any(within_each(times[30:32]))
    assert abs(times[31] - 1.7) < 0.1
    assert times[32] < 1.45
    assert levels[36].vpl_clusters == levels[29].vpl_clusters
    assert within(times[42:]) == 1.0


@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_a_change_of_the_cost_with_the_view_is_followed(noise: float) -> None:
    def plant(number: int, level: Level) -> Stages:
        parts = milliseconds(level)
        swing = np.sin(number / 15.0)  # twice as dear as where it is cheapest, within 47 frames
        return {**scaled(parts, 1.0 + 0.33 * swing), "fixed": parts["fixed"] * (1.0 + 0.2 * swing)}

    times, levels = walk(12.0, plant, 250, noise=noise)
    assert within(times[FEW:]) > 0.97
    assert light_sets(levels) < 10


def test_a_time_that_does_not_repeat_is_ignored() -> None:
    _, levels = walk(12.0, lambda _, level: milliseconds(level), 60, noise=0.0, outliers=(20, 30, 40, 50))
    assert moves(levels[FEW:]) == 0


@pytest.mark.parametrize("target", [1.0, 1e4])
def test_what_cannot_be_met_ends_at_the_end_of_the_levels(target: float) -> None:
    _, levels = walk(target, lambda _, level: milliseconds(level), 60)
    every = Levels(PIXELS, parameters=FOR_TIME)
    end = every.of(every.vpl_clusters[0])[0] if target == 1.0 else every.of(every.vpl_clusters[-1])[-1]
    assert levels[-1] == end
    assert target == 1.0 or replace(end, passes=1.0) == MOST
    assert moves(levels[40:]) == 0


def test_other_lights_are_waited_for_with_patience() -> None:
    governor = for_time(6.0)
    for _ in range(20):
        governor.learn(milliseconds(governor.level), anew=True)
    lights, asked = governor.level.vpl_clusters, []
    for number in range(40):
        factor = 0.05 if number in (5, 6, 12, 13) or number >= 20 else 1.0  # for two frames, then for good
        governor.learn(scaled(milliseconds(governor.level), factor))
        asked.append(governor.level.vpl_clusters != lights)
    assert not any(asked[:26])
    assert asked[30]


class Certain:
    """A model that knows: what levels give is in proportion to their work."""

    near, ready = 0.01, True

    def observe(self, level: Level, seen: None) -> None:
        """Nothing new."""

    def predict(self, level: Level) -> float:
        return level.work / USUAL.work


@pytest.mark.parametrize(("off", "changes"), [(1.06, False), (1.12, True)])
def test_lights_stay_where_their_levels_come_almost_near_enough(off: float, changes: bool) -> None:
    levels = Levels(PIXELS)
    most = levels.of(2048)[-1]
    governor = Governor(levels, Certain(), off * Certain().predict(most), most)
    for _ in range(20):
        governor.learn(None)
    assert (governor.level != most) == changes


@pytest.mark.parametrize(
    ("parameters", "target", "least", "most"),
    [(None, 100.0, 3.7, 4.0), (FOR_WALK, 100.0, 1.85, 2.0), (None, 0.01, 1.0 / 4.0, 1.0 / 3.7)],
)
def test_one_frame_changes_work_by_so_much_at_the_most(
    parameters: GovernorParameters | None, target: float, least: float, most: float
) -> None:
    governor = Governor(Levels(PIXELS), Certain(), target, USUAL, parameters)
    governor.learn(None)
    assert least <= governor.level.work / USUAL.work <= most


@pytest.mark.parametrize("rise", [1.25, 2.0])
def test_work_grows_and_falls_as_fast_as_it_may(rise: float) -> None:
    governor = for_time(40.0, GovernorParameters(rise=rise))
    works = []
    for number in range(60):
        works.append(governor.level.work)
        governor.learn(scaled(milliseconds(governor.level), 1.0 if number < 40 else 4.0))
    steps = np.array(works[1:]) / works[:-1]
    assert steps.max() <= rise
    assert sum(milliseconds(governor.level).values()) * 4.0 == pytest.approx(40.0, rel=0.1)
    assert steps.min() < 1.0 / 1.5
    assert max(works) > 4.0 * works[0]


def test_work_grows_fourfold_at_most_from_one_frame_to_the_next() -> None:
    _, levels = walk(1e4, lambda _, level: milliseconds(level), 10)
    works = np.array([level.work for level in levels])
    assert np.all(works[1:] / works[:-1] <= 4.0)
    assert works[-1] > 4.0 * works[0]


@dataclass(frozen=True)
class Room:
    """What frames of a walk take on an H200 [ms], roughly: whatever counts are, and by them.

    Where SP clusters are few, more VPL clusters are near each of them.

    pair: of shading, a pair of clusters; swing: by what share a walk's views take more or less.
    """

    fixed: float
    visibility: float
    shade: float
    pair: float
    swing: float

    def milliseconds(self, level: Level, frame: int) -> Stages:
        sps, vpls = level.sp_clusters / USUAL.sp_clusters, level.vpl_clusters / USUAL.vpl_clusters
        stages = {
            "fixed": 0.85 * self.fixed,
            "correct": 0.15 * self.fixed * level.passes**0.7,
            "visibility": self.visibility * (0.9 + 0.1 * sps * vpls),
            "shade": (self.shade * vpls**0.4 + self.pair * sps * vpls) * max(1.0, vpls / sps) ** 0.3,
            "refine": 0.4 * sps**0.3,
        }
        return scaled(stages, 1.0 + self.swing * np.sin(frame / 15.0))


CONFERENCE, SPONZA = Room(3.5, 0.29, 1.2, 0.03, 0.08), Room(3.7, 0.39, 0.97, 0.035, 0.06)
CORNELL_BOX = Room(1.5, 0.12, 0.32, 0.035, 0.14)


def walk_in(room: Room, target: float) -> tuple[np.ndarray, list[Level]]:
    """Times of a walk's frames over the target, and their levels."""
    random, governor = np.random.default_rng(5), for_time(target, FOR_WALK)
    times, levels = [], []
    for frame in range(200):
        stages = room.milliseconds(governor.level, frame)
        times.append(sum(stages.values()))
        levels.append(governor.level)
        governor.learn(scaled(stages, 1.0 + 0.02 * random.standard_normal()), anew=frame < 32)
    return np.array(times) / target, levels


@pytest.mark.parametrize("target", [5.0, 6.3, 9.0, 13.0])
@pytest.mark.parametrize("room", [CONFERENCE, SPONZA])
def test_walks_hold_a_time(room: Room, target: float) -> None:
    times, levels = walk_in(room, target)
    assert within(times[40:]) > 0.95
    assert light_sets(levels[40:]) < 3


@pytest.mark.parametrize(("target", "least"), [(2.3, 0.85), (2.7, 0.85), (3.5, 0.97), (4.5, 0.97)])
def test_walks_whose_views_change_much_hold_most_times(target: float, least: float) -> None:
    times, levels = walk_in(CORNELL_BOX, target)
    assert within(times[40:]) > least
    assert light_sets(levels[40:]) < 6


def test_a_first_picture_waits_until_the_level_stays() -> None:
    governor = for_time(30.0)
    waited = [governor.learn(milliseconds(governor.level), anew=True) for _ in range(FEW)]
    assert not waited[0]
    assert waited[-1]
    assert governor.expected == pytest.approx(sum(milliseconds(governor.level).values()), rel=0.05)
    assert governor.expected == pytest.approx(30.0, rel=0.1)


def for_error(target: float, levels: Levels | None = None) -> ErrorGovernor:
    """One that starts at about the usual counts."""
    levels = levels or Levels(PIXELS, 512, 8192)
    return ErrorGovernor(levels, target, levels.nearest(USUAL.work))


def error_of(level: Level, power: float) -> float:
    """1e-3 of usual counts, less with more VPL clusters by `power`; of SP clusters as measured in a Cornell box."""
    vpls = level.vpl_clusters / USUAL.vpl_clusters
    sps = level.sp_clusters / USUAL.sp_clusters / vpls
    return 1e-3 * float(vpls**-power * (1.0 + 0.12 * sps**-0.8) / 1.12)


def estimated(error: float, noise: float, random: np.random.Generator) -> Estimate:
    """Skewed, as the squares of differences are."""
    return Estimate(error * random.gamma(noise**-2, noise**2), noise * error)


def shown(governor: ErrorGovernor, error: Callable[[Level], float], noise: float, random: np.random.Generator) -> float:
    """The error of a frame's last try, of up to eight; tries are seen by the same probes, so with one noise."""
    seen = random.gamma(noise**-2, noise**2)
    for _ in range(8):
        level, last = governor.level, error(governor.level)
        governor.learn(Estimate(seen * last, noise * last))
        if not governor.try_again(level):
            break
    return last


def test_a_second_try_has_counts_that_promise_less() -> None:
    random, governor = np.random.default_rng(2), for_error(1e-3)
    for _ in range(30):
        governor.learn(estimated(error_of(governor.level, 0.7), 0.05, random))
    level = governor.level
    governor.learn(estimated(1.4 * error_of(level, 0.7), 0.05, random))
    assert governor.try_again(level)
    assert error_of(governor.level, 0.7) < 0.9 * error_of(level, 0.7)
    assert governor.expected == pytest.approx(1e-3, rel=0.1)


def test_a_second_try_is_of_the_same_view() -> None:
    """Views get a tenth harder each, the last by more: counts for the next one would leave too little error in it."""
    levels = Levels(PIXELS, 512, 16_384)
    governor = for_error(1e-3, levels)
    for number in range(24):
        hardness = 0.2 * 1.1 ** (number + 2 * (number == 23))
        level, error = governor.level, hardness * error_of(governor.level, 0.5)
        governor.learn(Estimate(error, 0.02 * error))
    following = hardness * error_of(governor.level, 0.5)
    assert governor.try_again(level)
    again = hardness * error_of(governor.level, 0.5)
    assert following < 0.93 * again
    assert again == pytest.approx(ErrorGovernorParameters().retry_aim * 1e-3, rel=0.15)


def test_first_tries_aim_above_what_is_wanted_and_others_higher() -> None:
    parameters = ErrorGovernorParameters(aim=1.2, retry_aim=1.5, too_large=1.6)
    levels = Levels(PIXELS, 512, 8192)
    governor = ErrorGovernor(levels, 1e-3, levels.nearest(USUAL.work), parameters)
    for _ in range(30):
        governor.learn(Estimate(error_of(governor.level, 0.7), 1e-5))
    level = governor.level
    assert error_of(level, 0.7) == pytest.approx(1.2e-3, rel=0.06)
    governor.learn(Estimate(1.59e-3, 1e-5))
    assert not governor.try_again(level)
    level = governor.level
    governor.learn(Estimate(1.7e-3, 1e-5))
    assert governor.try_again(level)
    assert governor.expected == pytest.approx(1.5e-3, rel=0.06)


@pytest.mark.parametrize(("off", "stays"), [(1.03, True), (1.07, False)])
def test_a_level_stays_that_is_near_enough(off: float, stays: bool) -> None:
    governor = for_error(1e-3)
    level, error = governor.level, off * ErrorGovernorParameters().aim * 1e-3
    governor.learn(Estimate(error, 1e-2 * error))
    assert (governor.level == level) == stays


def test_a_frame_is_shown_whose_error_is_little_above_what_tries_aim_at() -> None:
    governor = for_error(1e-3)
    for _ in range(30):
        governor.learn(Estimate(error_of(governor.level, 0.7), 1e-5))
    level = governor.level
    governor.learn(Estimate(1.079e-3, 1e-5))
    assert not governor.try_again(level)
    governor.learn(Estimate(1.15e-3, 1e-5))
    assert governor.try_again(governor.level)


def test_there_is_no_second_try_at_the_most_counts() -> None:
    random, governor = np.random.default_rng(2), for_error(1e-5)
    for _ in range(40):
        governor.learn(estimated(error_of(governor.level, 0.7), 0.05, random))
    level, expected = governor.level, governor.expected
    assert not governor.try_again(level)
    assert (governor.level, governor.expected) == (level, expected)


@pytest.mark.parametrize(("target", "power"), [(7e-4, 0.4), (5e-4, 0.7), (1.5e-3, 0.4), (1e-3, 0.25)])
def test_a_noisy_error_is_met(target: float, power: float) -> None:
    for seed in range(8):
        random, governor = np.random.default_rng(seed), for_error(target)
        errors = []
        for _ in range(100):
            errors.append(shown(governor, partial(error_of, power=power), 0.06, random))
        assert np.mean(errors[20:]) / target == pytest.approx(1.0, abs=0.05)
        assert within(np.array(errors[20:]) / target) > 0.85


def test_an_error_that_changes_with_the_view_is_held() -> None:
    """Four times as large where it is largest as where least, within 48 frames."""
    held, moved = [], []
    for seed in range(4):
        random, governor = np.random.default_rng(seed), for_error(1e-3, Levels(PIXELS, 64, 16_384))
        errors, levels = [], []
        for number in range(200):
            levels.append(governor.level)
            hardness = float(np.exp(log(2.0) * np.sin(2.0 * np.pi * number / 96.0)))
            errors.append(shown(governor, lambda level, h=hardness: h * error_of(level, 0.5), 0.04, random))
        held.append(within(np.array(errors[FEW:]) / 1e-3))
        moved.append(moves(levels))
    assert min(held) > 0.9
    assert max(moved) < 130


def test_other_vpl_clusters_are_within_reach_of_the_fewest_sp_clusters() -> None:
    """An easy view: 416 VPL clusters with the fewest SP clusters leave less error than wanted, the fewest do not."""
    levels = levels_of(PIXELS, 16_000)
    few, fewest = levels.of(416)[0], levels.of(352)[0]
    governor = ErrorGovernor(levels, 1e-3, few)

    def plant(level: Level) -> float:
        vpls, sps = level.vpl_clusters / few.vpl_clusters, level.sp_clusters / few.sp_clusters
        return float(8e-4 * vpls**-0.5 * sps**-0.2)

    for _ in range(20):
        governor.learn(Estimate(plant(governor.level), 1e-5))
    assert governor.level == fewest
    assert governor.expected == pytest.approx(plant(fewest), rel=0.05)


def test_noise_of_an_error_alone_moves_its_level_little() -> None:
    moved = []
    for seed in range(4):
        random, governor = np.random.default_rng(seed), for_error(1e-3)
        levels = []
        for _ in range(200):
            levels.append(governor.level)
            governor.learn(estimated(error_of(governor.level, 0.4), 0.06, random))
        moved.append(moves(levels[FEW:]))
        assert light_sets(levels[FEW:]) < 10
        assert np.std([log(error_of(level, 0.4)) for level in levels[FEW:]]) < 0.04
    assert np.mean(moved) < 60


def test_a_first_picture_waits_until_its_error_is_known_well() -> None:
    governor, random = for_error(1e-3), np.random.default_rng(1)
    waited = [governor.learn(estimated(error_of(governor.level, 0.4), 0.05, random)) for _ in range(40)]
    assert not any(waited[:5])
    assert any(waited[:FEW])


def test_an_error_below_what_can_be_is_told() -> None:
    governor = for_error(1e-4)
    for _ in range(60):
        governor.learn(Estimate(5e-4 + 0.5 * error_of(governor.level, 0.7), 1e-5))
    assert governor.level.vpl_clusters == 8192
    assert governor.expected == pytest.approx(5e-4 + 0.5 * error_of(governor.level, 0.7), rel=0.02)


def test_estimates_below_zero_count_as_little_error() -> None:
    levels = Levels(PIXELS)
    governor = for_error(1e-3, levels)
    for _ in range(60):
        governor.learn(Estimate(-1e-4, 1e-4))
    assert governor.level.vpl_clusters == 32


@pytest.mark.parametrize("error", [1.05e-3, 0.5e-3, float("nan")])
def test_what_is_not_too_large_is_not_tried_again(error: float) -> None:
    governor = for_error(1e-3)
    for _ in range(8):
        governor.learn(Estimate(1.2e-3, 1e-5))
    level = governor.level
    governor.learn(Estimate(error, 1e-5))
    assert not governor.try_again(level)

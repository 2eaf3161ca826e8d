from dataclasses import replace
from itertools import pairwise

import pytest

from gpu.adaptive.levels import FOR_TIME, MOST, Level, LevelParameters, Levels, levels_of

PIXELS = 600_000
USUAL = Level(8192, 2048)
STEP = 1.06
ONE_PASS = LevelParameters(below=2.0)


def test_levels_have_few_numbers_of_vpl_clusters_and_fine_steps_of_sp_clusters() -> None:
    levels = Levels(PIXELS)
    assert levels.vpl_clusters[0] == 32
    assert levels.vpl_clusters[-1] == MOST.vpl_clusters
    assert 30 < len(levels.vpl_clusters) < 40
    assert all(number % 32 == 0 for number in levels.vpl_clusters)
    assert levels.usual(2048) == USUAL
    assert levels.nearest(USUAL.work) == USUAL
    counts = sorted(level.sp_clusters for level in levels.of(2048))
    assert USUAL in levels.of(2048)
    assert all(1.0 < more / fewer < STEP + 0.01 for fewer, more in pairwise(counts))
    assert counts[-1] / 8192 == pytest.approx(6.0, rel=STEP - 1.0)
    assert 8192 / counts[0] == pytest.approx(48.0, rel=STEP - 1.0)
    assert max(level.sp_clusters for level in levels.of(MOST.vpl_clusters)) == MOST.sp_clusters


def test_the_fewest_sp_clusters_of_levels_can_be_bounded() -> None:
    few = Levels(PIXELS, parameters=ONE_PASS).of(2048)
    assert 8192 / few[0].sp_clusters == pytest.approx(2.0, rel=STEP - 1.0)
    assert few == Levels(PIXELS).of(2048)[-len(few) :]
    assert levels_of(PIXELS, 98_304, ONE_PASS).of(2048) == few


def test_passes_come_between_the_usual_number_of_sp_clusters_and_more() -> None:
    same = Levels(PIXELS, parameters=ONE_PASS).of(2048)
    more = Levels(PIXELS, parameters=FOR_TIME).of(2048)
    usual = more.index(USUAL)
    assert more[: usual + 1] == same[: usual + 1]
    passes = [level.passes for level in more if level.sp_clusters == 8192]
    assert passes[0] == 1.0
    assert all(1.0 < after / before < STEP + 0.01 for before, after in pairwise(passes))
    assert 3.7 < passes[-1] <= 4.0
    last = more[usual + len(passes) :]
    assert [replace(level, passes=1.0) for level in last] == list(same[usual + 1 :])
    assert {level.passes for level in last} == {passes[-1]}
    works = [level.work for level in more]
    assert works == sorted(works)


@pytest.mark.parametrize("pixels", [1, 100, 5000])
def test_small_images_have_no_more_clusters_than_pixels(pixels: int) -> None:
    levels = Levels(pixels)
    all_levels = [level for number in levels.vpl_clusters for level in levels.of(number)]
    assert all(1 <= level.sp_clusters <= pixels for level in all_levels)


def test_numbers_of_vpl_clusters_can_be_bounded() -> None:
    bounded = Levels(PIXELS, 200, 700).vpl_clusters
    assert bounded == [number for number in Levels(PIXELS).vpl_clusters if 200 <= number <= 700]
    assert Levels(PIXELS, 0, 1).vpl_clusters == [32]
    assert Levels(PIXELS, 520, 530).vpl_clusters == [512]


def test_clusters_of_given_vpls_have_some_members() -> None:
    assert levels_of(PIXELS, 16_000).vpl_clusters[0] == 352
    assert levels_of(PIXELS, 16_000).vpl_clusters[-1] == 1216

import pytest

from gpu.levels import Level
from gpu.time_model import FULL, NEAR, Growth, TimeModel, Times

GROWTHS = {"refine": Growth(sps=0.5), "shade": Growth(vpls=0.5, pairs=0.25)}


def model_of(level: Level, stages: dict[str, float], used: int | None = None) -> TimeModel:
    """One that has seen a frame, with as many clusters in use as are wanted unless `used` says otherwise."""
    model = TimeModel(level, GROWTHS)
    model.observe(level, Times(stages, used or level.sp_clusters))
    return model


def test_parts_that_no_count_changes_stay_in_a_prediction() -> None:
    model = model_of(Level(100, 10), {"fixed": 3.0, "refine": 1.0})
    assert model.predict(Level(100, 20)) == pytest.approx(4.0)
    assert model.predict(Level(900, 10)) == pytest.approx(6.0)


def test_a_share_of_a_stage_grows_with_pairs_of_clusters() -> None:
    model = model_of(Level(100, 10), {"fixed": 1.0, "shade": 4.0})
    assert model.predict(Level(100, 10)) == pytest.approx(5.0)
    assert model.predict(Level(200, 10)) == pytest.approx(1.0 + 3.0 + 2.0)
    assert model.predict(Level(100, 40)) == pytest.approx(1.0 + 3.0 * 2.0 + 4.0)


def test_a_time_is_of_the_clusters_in_use() -> None:
    model = model_of(Level(400, 10), {"refine": 2.0}, used=100)
    assert model.predict(Level(400, 10)) == pytest.approx(4.0)


def test_the_share_of_clusters_that_comes_into_use_is_learnt_when_no_more_come() -> None:
    level = Level(400, 10)
    model = model_of(level, {"refine": 2.0}, used=100)
    for used in range(110, 200, 10):
        model.observe(level, Times({"refine": 0.2 * used**0.5}, used))
        assert not model.ready
        assert model.predict(level) == pytest.approx(4.0)
    for _ in range(40):
        model.observe(level, Times({"refine": 0.2 * 200**0.5}, 200))
    assert model.ready
    assert model.predict(level) == pytest.approx(0.2 * 200**0.5, rel=1e-3)
    assert model.predict(Level(800, 10)) == pytest.approx(0.2 * 400**0.5, rel=1e-3)
    model.observe(level, Times({"refine": 4.0}, 400))
    assert model.predict(level) == pytest.approx(4.0, rel=0.02)


def test_nearly_all_clusters_are_enough_for_a_first_picture() -> None:
    level = Level(400, 10)
    model = model_of(level, {"fixed": 2.0}, used=100)
    for share in (0.5, FULL):
        model.observe(level, Times({"fixed": 2.0}, int(share * 400)))
    assert model.ready


def test_nothing_is_sure_before_the_second_frame() -> None:
    model = model_of(Level(100, 10), {"fixed": 3.0})
    assert not model.ready
    assert model.near > 4.0 * NEAR
    for _ in range(4):
        model.observe(Level(100, 10), Times({"fixed": 3.0}, 100))
    assert model.near == NEAR
    assert model.ready

import pytest

from gpu.adaptive.levels import Level
from gpu.adaptive.time_model import NEAR, TimeModel


def test_parts_that_no_count_changes_stay_in_a_prediction() -> None:
    model = TimeModel()
    model.observe(Level(100, 10), {"fixed": 3.0, "refine": 1.0})
    assert model.predict(Level(100, 20)) == pytest.approx(4.0)
    assert model.predict(Level(900, 10)) == pytest.approx(6.0)


def test_passes_change_what_correcting_takes_and_nothing_else() -> None:
    model = TimeModel()
    model.observe(Level(100, 10, 1.5), {"fixed": 3.0, "shade": 1.0, "correct": 1.0})
    assert model.predict(Level(100, 10, 3.0)) == pytest.approx(4.0 + 2.0**0.65)


def test_nothing_is_sure_before_the_second_frame() -> None:
    model = TimeModel()
    model.observe(Level(100, 10), {"fixed": 3.0})
    assert not model.ready
    assert model.near > 4.0 * NEAR
    for _ in range(4):
        model.observe(Level(100, 10), {"fixed": 3.0})
    assert model.near == NEAR
    assert model.ready

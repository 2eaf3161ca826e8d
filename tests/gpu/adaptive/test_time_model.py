import pytest

from gpu.adaptive.levels import Level
from gpu.adaptive.time_model import TimeModel


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
    assert model.near > 0.2
    for _ in range(4):
        model.observe(Level(100, 10), {"fixed": 3.0})
    assert 0.04 < model.near < 0.06
    assert model.ready


@pytest.mark.parametrize(
    ("stage", "sps", "vpls"), [("cluster", 1.15, 1.0), ("visibility", 1.74, 1.74), ("shade", 1.32, 1.74)]
)
def test_stages_take_longer_with_more_clusters(stage: str, sps: float, vpls: float) -> None:
    """Twice as many, as measured on an H100."""
    model = TimeModel()
    model.observe(Level(100, 10), {stage: 1.0})
    assert model.predict(Level(200, 10)) == pytest.approx(sps, rel=0.05)
    assert model.predict(Level(100, 20)) == pytest.approx(vpls, rel=0.05)


def test_two_frames_are_pooled() -> None:
    model = TimeModel()
    for number in range(20):
        assert model.ready == (number >= 2)
        model.observe(Level(100, 10), {"fixed": 3.0})
    model.observe(Level(100, 10), {"fixed": 3.3})
    assert 3.15 < model.predict(Level(100, 10)) < 3.27


def test_what_grows_is_expected_to_go_on() -> None:
    """By 4 percent each frame: without a trend it would be taken for 4 percent less, with half as much for longer."""
    model = TimeModel()
    misses = []
    for number in range(30):
        time = 3.0 * 1.04**number
        if number > 4:
            misses.append(model.predict(Level(100, 10)) / time - 1.0)
        model.observe(Level(100, 10), {"fixed": time})
    assert abs(misses[-1]) < 0.005
    assert min(misses) > -0.025
    assert max(misses) < 0.001


@pytest.mark.parametrize(("ratio", "believed"), [(1.4, True), (1.6, False)])
def test_a_surprise_counts_only_when_it_comes_again(ratio: float, believed: bool) -> None:
    model = TimeModel()
    for _ in range(4):
        model.observe(Level(100, 10), {"fixed": 3.0})
    model.observe(Level(100, 10), {"fixed": 3.0 * ratio})
    assert (model.predict(Level(100, 10)) > 3.1) == believed
    model.observe(Level(100, 10), {"fixed": 3.0 * ratio})
    assert model.predict(Level(100, 10)) > 3.5

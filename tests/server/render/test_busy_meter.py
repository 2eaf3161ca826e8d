import pytest

from server.render.busy_meter import SPAN_SECONDS, BusyMeter


def test_it_is_the_share_of_the_last_span() -> None:
    now = 100.0
    meter = BusyMeter(lambda: now)
    assert meter.share(7.0) == 0.0  # nothing is known yet
    now += SPAN_SECONDS
    assert meter.share(3.0) == pytest.approx(3.0 / SPAN_SECONDS)
    now += SPAN_SECONDS / 2.0
    assert meter.share(5.0) == pytest.approx(3.0 / SPAN_SECONDS)
    now += SPAN_SECONDS / 2.0
    assert meter.share(5.0) == pytest.approx(2.0 / SPAN_SECONDS)


def test_a_turn_longer_than_the_span_is_no_more_than_all_of_it() -> None:
    now = 0.0
    meter = BusyMeter(lambda: now)
    now = SPAN_SECONDS
    assert meter.share(100.0) == 1.0

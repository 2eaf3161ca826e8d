from datetime import UTC, datetime, timedelta, timezone
from math import cos, radians, sin

import pytest

from gpu.scene.lighting.sun import sun_direction, sun_position, sun_strength


def test_the_sun_stands_where_it_was_published() -> None:
    """I. Reda, A. Andreas, "Solar position algorithm for solar radiation applications", NREL/TP-560-34302, table A5.1:
    with refraction, which is 0.016° there.
    """
    time = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
    azimuth, height = sun_position(39.742476, -105.1786, time)
    assert azimuth == pytest.approx(194.34024, abs=0.01)
    assert height == pytest.approx(90.0 - 50.11162 - 0.0163, abs=0.01)


def test_the_sun_is_overhead_at_the_tropics_and_never_sets_in_polar_summer() -> None:
    # The solstice of June 2024 was at 20:51 UTC, and noon of that time is at 47.5° west.
    assert sun_position(23.436, -132.3, datetime(2024, 6, 20, 20, 51, tzinfo=UTC))[1] > 89.5
    night = sun_position(78.2, 15.6, datetime(2024, 6, 20, 23, 0, tzinfo=UTC))
    assert night[1] == pytest.approx(23.44 - (90.0 - 78.2), abs=0.1)
    assert min(night[0], 360.0 - night[0]) < 2.0
    assert sun_position(51.5, 0.0, datetime(2024, 12, 21, 12, 0, tzinfo=UTC))[1] == pytest.approx(15.06, abs=0.1)
    east, _ = sun_position(0.0, 0.0, datetime(2024, 3, 20, 7, 0, tzinfo=UTC))
    assert east == pytest.approx(90.0, abs=1.0)


def test_its_light_goes_away_from_it() -> None:
    assert sun_direction(180.0, 90.0, 0.0) == pytest.approx((0.0, -1.0, 0.0))
    assert sun_direction(180.0, 0.0, 0.0) == pytest.approx((0.0, 0.0, -1.0))  # from the south to the north, −Z
    assert sun_direction(90.0, 30.0, 0.0) == pytest.approx((-cos(radians(30.0)), -sin(radians(30.0)), 0.0))
    assert sun_direction(90.0, 0.0, 90.0) == pytest.approx(sun_direction(180.0, 0.0, 0.0))


def test_it_is_red_when_it_is_low_and_gone_when_it_is_down() -> None:
    assert sun_strength(90.0) == pytest.approx((1.0, 1.0, 1.0), abs=2e-3)
    low = sun_strength(5.0)
    assert low[0] > low[1] > low[2] > 0.0
    assert low[0] < 0.75 * sun_strength(40.0)[0]
    assert max(sun_strength(0.01)) < 0.2
    assert sun_strength(-0.1) == (0.0, 0.0, 0.0)

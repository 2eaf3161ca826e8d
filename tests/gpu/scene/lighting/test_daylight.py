import numpy as np
import pytest

from gpu.scene.lighting.daylight import HEIGHT, daylight
from gpu.scene.types import Doubles

COLUMNS = 2 * HEIGHT


def upper(height: float, bearing: float = 0.0) -> Doubles:
    return daylight(height, bearing)[: HEIGHT // 2].astype(np.float64)


def irradiance(picture: Doubles) -> float:
    down = (np.arange(len(picture)) + 0.5) * np.pi / HEIGHT
    rows = np.cos(down) * np.sin(down) * np.pi / HEIGHT
    return float((picture.mean(axis=(1, 2)) * rows).sum() * 2.0 * np.pi)


def test_a_sun_overhead_gives_what_an_even_sky_does_and_a_lower_one_less() -> None:
    found = [irradiance(upper(height)) for height in (90.0, 60.0, 30.0, 5.0, 0.0)]
    assert found[0] == pytest.approx(np.pi, rel=1e-3)
    assert found == sorted(found, reverse=True)
    assert irradiance(upper(-6.0)) == pytest.approx(found[-1] * 10 ** (-6.0 * 0.345), rel=1e-3)
    assert 0.0 < irradiance(upper(-80.0)) < 1e-5


@pytest.mark.parametrize("bearing", [0.0, 90.0, 200.0])
def test_it_is_brightest_about_the_sun(bearing: float) -> None:
    row, column = np.unravel_index(upper(40.0, bearing).sum(axis=2).argmax(), (HEIGHT // 2, COLUMNS))
    assert row == pytest.approx((90.0 - 40.0) / 180.0 * HEIGHT, abs=1.0)
    assert abs((column + 0.5 - bearing / 360.0 * COLUMNS + HEIGHT) % COLUMNS - HEIGHT) <= 1.0


def test_it_is_blue_above_and_red_where_the_sun_sets() -> None:
    red, green, blue = upper(40.0)[0].mean(axis=0)
    assert blue > 1.5 * green > 1.5 * red
    red, green, blue = upper(2.0)[-1, 0]
    assert red > 1.3 * green > 3.0 * blue


def test_luminance_falls_away_from_the_sun_as_perez_formula_does() -> None:
    """Of turbidity 2.5, from the zenith to 60° from it on the far side of a sun at 60°, of which 120° are away."""
    a, b, c, d, e = -1.01625, -0.461, 5.26835, -2.2756, 0.2028

    def perez(down: float, away: float) -> float:
        near = 1.0 + c * np.exp(d * away) + e * np.cos(away) ** 2
        return float((1.0 + a * np.exp(b / np.cos(down))) * near)

    picture = upper(30.0) @ (0.2126, 0.7152, 0.0722)
    row = 21  # of whose middle the angle from the zenith is
    down = (row + 0.5) * np.pi / HEIGHT
    top = 0.5 * np.pi / HEIGHT
    far = picture[row, [HEIGHT - 1, HEIGHT]].mean() / picture[0, [HEIGHT - 1, HEIGHT]].mean()
    sun = np.radians(60.0)
    assert far == pytest.approx(perez(down, sun + down) / perez(top, sun + top), rel=5e-3)


def test_the_ground_is_a_fifth_of_what_lies_on_it() -> None:
    ground = daylight(50.0, 0.0)[HEIGHT // 2 :]
    assert np.ptp(ground, axis=(0, 1)).max() == 0.0
    assert ground.mean() * np.pi == pytest.approx(0.2 * irradiance(upper(50.0)), rel=2e-3)


def test_the_same_sun_has_the_same_array_that_nobody_changes() -> None:
    assert daylight(33.0, 12.0) is daylight(33.0, 12.0)
    assert not daylight(33.0, 12.0).flags.writeable

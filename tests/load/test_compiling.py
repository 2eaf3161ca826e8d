import pytest

from tests.load.compiling import longest_gap


def test_the_longest_time_without_a_frame_is_within_what_is_looked_at() -> None:
    assert longest_gap([0.0, 1.0, 1.5, 9.0], 0.5, 2.5) == pytest.approx(1.0)
    assert longest_gap([], 1.0, 3.0) == pytest.approx(2.0)

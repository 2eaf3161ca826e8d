import pytest

from tests.bench.targets import changes, held


def test_what_is_within_a_tenth_of_its_target_is_held() -> None:
    measured = held([9.0, 10.0, 11.0, 11.2], 10.0)
    assert measured["within"] == 0.75
    assert measured["mean"] == pytest.approx(1.03)
    assert measured["median"] == pytest.approx(1.05)


def test_changes_of_counts_are_counted() -> None:
    assert changes([(1, 2), (1, 2), (1, 3), (1, 2)]) == 2
    assert changes([(1, 2)]) == 0

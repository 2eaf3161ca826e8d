from tests.bench.still import is_kept


def test_powers_of_two_and_the_last_frame_within_a_second_are_kept() -> None:
    kept = [number for number in range(1, 70) if is_kept(number, 0.021 * number, 0.021)]
    assert kept == [1, 2, 4, 8, 16, 32, 47, 64]


def test_a_slow_first_frame_is_kept_once() -> None:
    assert [number for number in range(1, 5) if is_kept(number, 3.0 * number, 3.0)] == [1, 2, 4]

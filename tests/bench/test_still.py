from itertools import pairwise

import numpy as np
import pytest

from tests.bench.still import is_kept, tile_change


@pytest.mark.parametrize(
    ("times", "wanted"),
    [
        ([0.021] * 70, [1, 2, 4, 8, 16, 32, 47, 64]),
        ([3.0] * 5, [1, 2, 4]),  # a slow first frame is kept once
        ([0.3, 0.1, 0.3, 0.1, 0.1, 0.3, 0.1, 0.3], [1, 2, 4, 5]),  # though frame 6 takes longer than frame 5
    ],
)
def test_powers_of_two_and_the_last_frame_within_a_second_are_kept(times: list[float], wanted: list[int]) -> None:
    ready = [sum(times[: number + 1]) for number in range(len(times))]
    kept = [
        number for number, (here, following) in enumerate(pairwise(ready), start=1) if is_kept(number, here, following)
    ]
    assert kept == wanted


def test_the_change_of_a_picture_is_that_of_its_worst_tile() -> None:
    first = np.ones((33, 50, 3))
    picture = first.copy()
    picture[:2] *= 1.01
    picture[-4:, -6:] *= 0.9
    assert tile_change(first, first) == 0.0
    assert tile_change(first, picture) == pytest.approx(0.1)
    first[:4, :6] = picture[:4, :6] = 0.0
    assert tile_change(first, picture) == pytest.approx(0.1, rel=0.01)

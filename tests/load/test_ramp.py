import asyncio

import pytest

from tests.load.ramp import climb, search


@pytest.mark.parametrize("most", [1, 7, 64])
@pytest.mark.parametrize("limit", [0, 1, 2, 5, 7, 12, 63, 64, 100])
def test_the_search_finds_the_largest_number_in_few_trials(limit: int, most: int) -> None:
    trials: list[int] = []

    async def fits(viewers: int) -> bool:
        trials.append(viewers)
        return viewers <= limit

    assert asyncio.run(search(fits, most)) == min(limit, most)
    assert len(trials) == len(set(trials)) <= 2 * most.bit_length()
    assert max(trials) <= most


def test_a_climb_tries_all_and_counts_up_to_the_first_that_does_not_fit() -> None:
    trials: list[int] = []

    async def fits(viewers: int) -> bool:
        trials.append(viewers)
        return viewers in (1, 4, 32)

    assert asyncio.run(climb(fits, [32, 1, 16, 4])) == 4
    assert trials == [1, 4, 16, 32]

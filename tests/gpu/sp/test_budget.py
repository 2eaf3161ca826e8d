"""How many clusters stay, are lacking and may be new."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results
from walking import budget_of

from gpu.gbuffer.point_list import PointList
from gpu.sp.budget import (
    SP_CLUSTER_PARAMETERS,
    WHOLE_DEFICIT,
    ClusterBudget,
    SpClusterParameters,
    adapt_budget_kernel,
    lacking_of,
    room_of,
)

CHOSEN = SP_CLUSTER_PARAMETERS


def points_of(count: int) -> PointList:
    points = PointList()
    points.count = column([count], wp.int32)
    return points


@wp.kernel
def lacking_kernel(first: int, deficit_sums: wp.array[int], points: PointList, budget: ClusterBudget,
                   out: wp.array[int]) -> None:  # fmt: skip
    """One thread: how many clusters are lacking."""
    index = first + wp.tid()
    out[index] = lacking_of(deficit_sums, points, budget)


def test_sps_of_a_whole_deficit_lack_their_share_of_all_clusters() -> None:
    sums = column(np.cumsum([0, int(WHOLE_DEFICIT)] * 1000), wp.int32)
    assert results(lacking_kernel, 1, [sums, points_of(2000), budget_of(8000, 1.0)], wp.int32).tolist() == [4000]
    # More than an int holds on the way.
    sums = column([0, 2_000_000 * int(WHOLE_DEFICIT)], wp.int32)
    assert results(lacking_kernel, 1, [sums, points_of(2), budget_of(1000, 1.0)], wp.int32)[0] == 1_000_000_000


def adapted(
    unused: int,
    lacking: int,
    accepted_distance: float = CHOSEN.accepted_distance,
    *,
    sps: int = 100,
    max_new: int = 1000,
    extent: int = 0,
) -> tuple[float, int, int]:
    """The accepted distance after a frame of 1000 clusters, `max_new` of them new, how many may be new in the next, and
    how many places are looked at. There are 500 places more, which are not to be used."""
    budget = budget_of(1000, accepted_distance, max_new, extent)
    sums = column([0] * 99 + [lacking * int(WHOLE_DEFICIT) // 10], wp.int32)
    unused_prefix = column([0] * 1499 + [500 + unused], wp.int32)
    wp.launch(adapt_budget_kernel, 1, [0, points_of(sps), sums, unused_prefix, CHOSEN, budget], device="cpu")
    arrays = budget.accepted_distance, budget.max_new, budget.extent
    distance, new, places = (array.numpy()[0] for array in arrays)
    return float(distance), int(new), int(places)


def adapted_distance(unused: int, lacking: int, distance: float = CHOSEN.accepted_distance, sps: int = 100) -> float:
    return adapted(unused, lacking, distance, sps=sps)[0]


def test_all_may_be_new_again_once_no_more_are_lacking_than_may_be_new() -> None:
    assert [adapted(300, lacking, max_new=60)[1] for lacking in (300, 100, 60, 0)] == [60, 60, 1000, 1000]
    assert adapted(300, 0, sps=0, max_new=60)[1] == 60


def test_places_that_were_in_use_are_looked_at_as_well_as_all_that_may_be() -> None:
    assert [adapted(300, 0, extent=extent)[2] for extent in (0, 1000, 1400)] == [1000, 1000, 1400]
    assert adapted(300, 0, sps=0, extent=400)[2] == 1000


@wp.kernel
def room_kernel(first: int, unused_prefix: wp.array[int], budget: ClusterBudget, chosen: SpClusterParameters,
                out: wp.array[int]) -> None:  # fmt: skip
    """One thread: how many clusters may be new."""
    index = first + wp.tid()
    out[index] = room_of(unused_prefix, budget, chosen)


def room(unused: int, wanted: int, distance: float = CHOSEN.accepted_distance) -> int:
    """Of 100 places, for so many clusters."""
    inputs = [column([0] * 99 + [unused], wp.int32), budget_of(wanted, distance), CHOSEN]
    return int(results(room_kernel, 1, inputs, wp.int32)[0])


def test_no_more_clusters_than_wanted_have_room_and_a_sixteenth_where_some_go() -> None:
    wanted = (100, 90, 70, 69, 50, 10)
    assert [room(30, number) for number in wanted] == [30, 20, 0, 4, 3, 0]  # 70 of 100 places are in use
    # A distance that cannot grow to make room.
    assert [room(30, number, CHOSEN.max_accepted) for number in wanted] == [30, 20, 4, 4, 3, 0]
    assert room(2, 90) == 2


def test_the_accepted_distance_follows_how_many_clusters_stay_free() -> None:
    resting = float(np.float32(CHOSEN.accepted_distance))
    for unused, lacking in ((11, 0), (35, 0), (130, 100)):
        assert adapted_distance(unused, lacking) == resting
    assert adapted_distance(300, 0, sps=0) == resting
    assert adapted_distance(9, 0) == pytest.approx(resting * (1.0 + 0.5 * 0.011))
    assert adapted_distance(50, 0) == pytest.approx(resting * (1.0 - 0.5 * 0.03))
    assert adapted_distance(0, 0) == pytest.approx(resting * (1.0 + 0.5 * 0.02))
    assert adapted_distance(100, 0) == adapted_distance(500, 100) == pytest.approx(resting * 0.97)
    assert adapted_distance(100, 300) == pytest.approx(resting * 1.03)
    assert adapted_distance(0, 500, CHOSEN.max_accepted) == pytest.approx(1.2)
    assert adapted_distance(500, 0, CHOSEN.min_accepted) == pytest.approx(0.4)

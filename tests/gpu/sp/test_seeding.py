"""Clusters for SPs that others serve badly."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.scene.types import Doubles
from gpu.sp.seeding import (
    ACCEPTED_DISTANCE,
    DEFICIT_IN_FRAME,
    DEFICIT_TO_FILL,
    MAX_ACCEPTED_DISTANCE,
    MIN_ACCEPTED_DISTANCE,
    MOST_CHANGE,
    UNSERVED_DEFICIT,
    WHOLE_DEFICIT,
    DeficitScale,
    adapt_kernel,
    deficit_of,
    drawn_sp,
    lacking_of,
    room_of,
)


@wp.kernel
def draw_kernel(first: int, totals: wp.array[int], count: int, number: int, out: wp.array[int]) -> None:
    """One thread a draw."""
    index = first + wp.tid()
    out[index] = drawn_sp(totals, count, index, number)


@wp.kernel
def need_kernel(first: int, scale: DeficitScale, accepted_distance: float, alike: bool, spacings: wp.array[float],
                out: wp.array[int]) -> None:  # fmt: skip
    """One thread a distance."""
    index = first + wp.tid()
    out[index] = deficit_of(scale, accepted_distance, spacings[index], alike)


def drawn(deficit: list[int], number: int) -> list[int]:
    """The SPs that `number` draws fall on."""
    totals = column(np.cumsum(deficit), wp.int32)
    return [int(sp) for sp in results(draw_kernel, number, [totals, len(deficit), number], wp.int32)]


def test_draws_are_in_proportion_to_need() -> None:
    deficit = np.random.default_rng(0).integers(0, 9, 4000)
    taken = [sp for sp in drawn(deficit.tolist(), 500) if sp >= 0]
    assert len(taken) == len(set(taken)) == 500
    assert (deficit[taken] > 0).all()
    quarters = np.histogram(taken, bins=4, range=(0, 4000))[0]
    assert quarters == pytest.approx(500 * deficit.reshape(4, 1000).sum(axis=1) / deficit.sum(), abs=1.01)
    assert deficit[taken].mean() == pytest.approx((deficit**2).sum() / deficit.sum(), rel=0.1)


def test_an_sp_is_drawn_once_and_none_without_need() -> None:
    assert drawn([0, 5, 0, 100, 0], 10) == [3] + [-1] * 9
    assert drawn([50, 0, 50], 4) == [0, -1, 2, -1]
    assert drawn([0, 0, 0], 3) == [-1] * 3
    assert drawn([7], 2) == [0, -1]


def needs(scale: DeficitScale, accepted_distance: float, *, alike: bool = True) -> Doubles:
    distances = column([0.0, 0.74, 0.875, 1.0, 2.0, 100.0], float)
    return results(need_kernel, 6, [scale, accepted_distance, alike, distances], wp.int32)


def test_need_grows_with_distance_up_to_a_bound() -> None:
    assert needs(DEFICIT_IN_FRAME, 1.0).tolist() == [0, 0, 0, 0, 16, 255]
    assert needs(DEFICIT_IN_FRAME, 1.0, alike=False).tolist() == needs(DEFICIT_IN_FRAME, 1.0).tolist()
    whole = int(WHOLE_DEFICIT)
    assert needs(DEFICIT_TO_FILL, 0.75).tolist() == [
        0,
        0,
        whole // 2,
        whole,
        DEFICIT_TO_FILL.most,
        DEFICIT_TO_FILL.most,
    ]
    assert min(needs(DEFICIT_TO_FILL, 0.75, alike=False)) >= whole
    assert DEFICIT_IN_FRAME.unserved == int(UNSERVED_DEFICIT)
    assert DEFICIT_TO_FILL.unserved > whole


@wp.kernel
def lacking_kernel(first: int, totals: wp.array[int], count: int, clusters: int, out: wp.array[int]) -> None:
    """One thread: how many clusters are lacking."""
    index = first + wp.tid()
    out[index] = lacking_of(totals, count, clusters)


def test_sps_in_whole_need_lack_their_share_of_all_clusters() -> None:
    totals = column(np.cumsum([0, int(WHOLE_DEFICIT)] * 1000), wp.int32)
    assert results(lacking_kernel, 1, [totals, 2000, 8000], wp.int32).tolist() == [4000]
    # More than an int holds on the way.
    totals = column([0, 2_000_000 * int(WHOLE_DEFICIT)], wp.int32)
    assert results(lacking_kernel, 1, [totals, 2, 1000], wp.int32)[0] == 1_000_000_000


def adapted(
    unused: int,
    lacking: int,
    accepted_distance: float = ACCEPTED_DISTANCE,
    *,
    sps: int = 100,
    most: int = 1000,
    extent: int = 0,
) -> tuple[float, int, int]:
    """The good distance after a frame of 1000 clusters, `most` of them new, how many may be new in the next, and how
    many places are looked at. There are 500 places more, which are not to be used."""
    held, new, extents = column([accepted_distance], float), column([most], wp.int32), column([extent], wp.int32)
    totals = column([0] * 99 + [lacking * int(WHOLE_DEFICIT) // 10], wp.int32)
    wanted, unused_prefix = column([1000], wp.int32), column([0] * 1499 + [500 + unused], wp.int32)
    inputs = [0, column([sps], wp.int32), totals, wanted, unused_prefix, held, new, extents]
    wp.launch(adapt_kernel, 1, inputs, device="cpu")
    return float(held.numpy()[0]), int(new.numpy()[0]), int(extents.numpy()[0])


def adapted_good(unused: int, lacking: int, accepted_distance: float = ACCEPTED_DISTANCE, sps: int = 100) -> float:
    return adapted(unused, lacking, accepted_distance, sps=sps)[0]


def test_all_may_be_new_again_once_no_more_are_lacking_than_may_be_new() -> None:
    assert [adapted(300, lacking, most=60)[1] for lacking in (300, 100, 60, 0)] == [60, 60, 1000, 1000]
    assert adapted(300, 0, sps=0, most=60)[1] == 60


def test_places_that_were_in_use_are_looked_at_as_well_as_all_that_may_be() -> None:
    assert [adapted(300, 0, extent=extent)[2] for extent in (0, 1000, 1400)] == [1000, 1000, 1400]
    assert adapted(300, 0, sps=0, extent=400)[2] == 1000


@wp.kernel
def room_kernel(
    first: int, unused: wp.array[int], wanted: wp.array[int], accepted_distance: float, out: wp.array[int]
) -> None:
    """One thread a number of clusters."""
    index = first + wp.tid()
    out[index] = room_of(unused, wanted[index], accepted_distance)


def test_no_more_clusters_than_wanted_have_room_and_a_sixteenth_where_some_go() -> None:
    unused = column([0] * 99 + [30], wp.int32)  # 70 of 100 places are in use
    wanted = column([100, 90, 70, 69, 50, 10], wp.int32)
    assert results(room_kernel, 6, [unused, wanted, ACCEPTED_DISTANCE], wp.int32).tolist() == [30, 20, 0, 4, 3, 0]
    most = float(MAX_ACCEPTED_DISTANCE)  # that cannot grow to make room
    assert results(room_kernel, 6, [unused, wanted, most], wp.int32).tolist() == [30, 20, 4, 4, 3, 0]
    unused = column([0] * 99 + [2], wp.int32)
    assert results(room_kernel, 1, [unused, column([90], wp.int32), ACCEPTED_DISTANCE], wp.int32).tolist() == [2]


def test_the_good_distance_follows_how_many_clusters_stay_free() -> None:
    resting = float(np.float32(ACCEPTED_DISTANCE))
    for unused, lacking in ((15, 0), (35, 0), (130, 100)):
        assert adapted_good(unused, lacking) == resting
    assert adapted_good(300, 0, sps=0) == resting
    assert adapted_good(50, 0) == pytest.approx(resting * (1.0 - 0.5 * 0.03))
    assert adapted_good(0, 0) == pytest.approx(resting * (1.0 + 0.5 * 0.02))
    assert adapted_good(100, 0) == adapted_good(500, 100) == pytest.approx(resting * (1.0 - float(MOST_CHANGE)))
    assert adapted_good(100, 300) == pytest.approx(resting * (1.0 + float(MOST_CHANGE)))
    assert adapted_good(0, 500, float(MAX_ACCEPTED_DISTANCE)) == pytest.approx(float(MAX_ACCEPTED_DISTANCE))
    assert adapted_good(500, 0, float(MIN_ACCEPTED_DISTANCE)) == pytest.approx(float(MIN_ACCEPTED_DISTANCE))

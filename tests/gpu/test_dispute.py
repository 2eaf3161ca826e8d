import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.dispute import BLOCK, WorstPoints
from gpu.shade import Indirect, allocate_indirect
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import UNSERVED_NEED

CPU = wp.get_device("cpu")
PIXELS = 400
COUNT = 300  # of the pixels, so many have an SP


def sps_backwards() -> ShadingPoints:
    """SP k lies at pixel 399 − k."""
    sps = ShadingPoints((20, 20), CPU)
    sps.pixels = column(PIXELS - 1 - np.arange(PIXELS), wp.int32)
    sps.count = column([COUNT], wp.int32)
    return sps


def light(low: np.ndarray, high: np.ndarray) -> Indirect:
    indirect = allocate_indirect(PIXELS, CPU)
    indirect.low, indirect.high = column(low, float), column(high, float)
    return indirect


def worst(capacity: int, low: np.ndarray, high: np.ndarray, *, need: dict[int, int] | None = None,
          stopped: dict[int, float] | None = None) -> list[int]:  # fmt: skip
    """The SPs that are listed, in the list's order."""
    needs, shares = np.zeros(PIXELS), np.zeros(PIXELS)
    for values, chosen in ((needs, need), (shares, stopped)):
        for sp, value in (chosen or {}).items():
            values[sp] = value
    points = WorstPoints(PIXELS, capacity, 0.25, CPU)
    points.find(sps_backwards(), column(needs, wp.int32), light(low, high), column(shares, float))
    return [PIXELS - 1 - int(pixel) for pixel in points.pixels.numpy()[: points.count.numpy()[0]]]


def test_those_in_dispute_are_listed_in_the_order_of_the_sps() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    high[[200, 17, 120]] = 2.0
    high[40] = 1.1  # too little to matter
    high[350] = 9.0  # no SP
    assert worst(50, low, high) == [17, 120, 200]


def test_the_worst_come_first_where_the_list_is_short() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    disputed = np.arange(10, 110, 10)
    high[disputed] = 2.0 ** np.arange(1, 11)
    assert worst(4, low, high) == disputed[-4:].tolist()


@pytest.mark.parametrize("listed", [0, 1, 20, 21])
def test_a_list_may_be_empty_or_exactly_full(listed: int) -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    high[:listed] = 3.0
    assert worst(20, low, high) == list(range(min(listed, 20)))


def test_sps_without_a_cluster_come_before_all_others() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    high[:30] = 1000.0
    assert worst(2, low, high, need={250: int(UNSERVED_NEED), 90: int(UNSERVED_NEED), 5: 255}) == [90, 250]


def test_stopped_rays_list_an_sp_and_its_neighbours() -> None:
    flat = np.ones(PIXELS)
    listed = worst(100, flat, flat, stopped={33: 1.0})
    assert listed == [33]
    block = int(BLOCK)
    listed = worst(100, flat, flat, stopped=dict.fromkeys(range(2 * block, 2 * block + block // 2), 1.0))
    assert listed == list(range(2 * block, 3 * block))


def test_nothing_is_worth_a_ray_in_the_dark() -> None:
    low, high = np.zeros(PIXELS), np.full(PIXELS, 1e-5)
    low[:150], high[:150] = 10.0, 10.0
    assert worst(100, low, high) == []
    assert worst(100, np.zeros(PIXELS), np.zeros(PIXELS)) == []

import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.core.device import allocate
from gpu.correction.brightness import MeanBrightness
from gpu.correction.outliers import OutlierPoints
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ListedPoints, ShadingPoints
from gpu.sp.sp_clusters import UNSERVED_DEFICIT

CPU = wp.get_device("cpu")
PIXELS = 400
COUNT = 300  # of the pixels, so many have an SP


def sps_backwards() -> ShadingPoints:
    """SP k lies at pixel 399 − k."""
    sps = ShadingPoints((20, 20), 1, CPU)
    sps.pixels.assign(PIXELS - 1 - np.arange(PIXELS, dtype=np.int32))
    sps.count.fill_(COUNT)
    return sps


def by_pixel(values: np.ndarray) -> wp.array:
    """Grey values of SPs as an array of pixels."""
    return column(np.repeat(values[::-1, None], 3, axis=1), wp.vec3)


def worst(capacity: int, low: np.ndarray, high: np.ndarray, *, deficit: dict[int, int] | None = None,
          albedo: np.ndarray | None = None, among: int | None = None) -> list[int]:  # fmt: skip
    """The SPs that are listed, in the list's order, where their own rays say `low` and their neighbours' `high`.

    among: how many may be in a first list, of which those are.
    """
    needs = np.zeros(PIXELS)
    for sp, value in (deficit or {}).items():
        needs[sp] = value
    gbuffer: GBuffer = allocate(GBuffer, PIXELS, CPU)
    gbuffer.albedo = by_pixel(np.full(PIXELS, np.pi) if albedo is None else albedo * np.pi)
    gbuffer.throughput.fill_(1.0)
    irradiance = 0.5 * (np.maximum(low, 0.0) + high)
    sps, mean = sps_backwards(), MeanBrightness(CPU)
    mean.find(gbuffer, sps, by_pixel(irradiance))
    light = [by_pixel(irradiance), by_pixel(low - irradiance), by_pixel(high - irradiance)]
    listed: ListedPoints = sps
    for count in (capacity,) if among is None else (among, capacity):
        points = OutlierPoints(listed.capacity, count, CPU)
        points.find(listed, gbuffer, column(needs, wp.int32), *light, mean)
        listed = points
    count = points.count.numpy()[0]
    assert np.array_equal(points.pixels.numpy()[:count], PIXELS - 1 - points.numbers.numpy()[:count])
    return [int(number) for number in points.numbers.numpy()[:count]]


def test_those_in_dispute_are_listed_in_the_order_of_the_sps() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    high[[200, 17, 120]] = 2.0
    high[40] = 1.1  # too little to matter
    high[350] = 9.0  # no SP
    assert worst(50, low, high) == [17, 120, 200]


def test_what_is_too_dark_is_left_alone() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    low[:100] = 5.0
    assert worst(50, low, high) == []


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


def test_a_list_may_hold_every_sp() -> None:
    assert worst(PIXELS, np.ones(PIXELS), np.full(PIXELS, 3.0)) == list(range(COUNT))


def test_sps_without_a_cluster_come_before_all_others() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    high[:30] = 1000.0
    assert worst(2, low, high, deficit={250: int(UNSERVED_DEFICIT), 90: int(UNSERVED_DEFICIT), 5: 255}) == [90, 250]


@pytest.mark.parametrize("lows", [(-100.0, 0.0), (0.0, -100.0)])
def test_rays_that_find_less_than_nothing_find_nothing(lows: tuple[float, float]) -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    low[[3, 70]], high[[3, 70]] = lows, 2.0
    # Both are as bad, so that where there is room for one it is the first.
    assert worst(1, low, high) == [3]


def test_nothing_is_worth_a_ray_in_the_dark() -> None:
    low, high = np.zeros(PIXELS), np.full(PIXELS, 1e-5)
    low[:150], high[:150] = 10.0, 10.0
    assert worst(100, low, high) == []
    assert worst(100, np.zeros(PIXELS), np.zeros(PIXELS)) == []


def test_a_quarter_too_much_matters_and_a_tenth_of_the_mean_is_dark() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    high[[20, 30]] = 1.32, 1.2  # a quarter of 1 and a tenth
    low[[40, 50]], high[[40, 50]] = 0.0, (0.032, 0.019)  # of a tenth
    assert worst(50, low, high) == [20, 40]


def test_what_reflects_hardly_any_light_is_in_the_dark() -> None:
    low, high, albedo = np.ones(PIXELS), np.ones(PIXELS), np.ones(PIXELS)
    high[[20, 30]] = 2.0
    albedo[20] = 1e-3
    assert worst(50, low, high, albedo=albedo) == [30]


def test_the_worst_of_a_list_of_suspects_are_suspects() -> None:
    low, high = np.ones(PIXELS), np.ones(PIXELS)
    disputed = np.arange(10, 110, 10)
    high[disputed] = 2.0 ** np.arange(1, 11)
    assert worst(3, low, high, among=5, deficit={200: int(UNSERVED_DEFICIT)}) == [90, 100, 200]
    assert worst(8, low, high, among=2) == [90, 100]
    assert worst(PIXELS, low, high, among=PIXELS) == disputed.tolist()


def test_a_picture_is_as_bright_as_its_mean_sample() -> None:
    gbuffer: GBuffer = allocate(GBuffer, PIXELS, CPU)
    gbuffer.albedo, irradiance = by_pixel(np.full(PIXELS, np.pi)), np.arange(PIXELS, dtype=float)
    gbuffer.throughput.fill_(1.0)
    mean = MeanBrightness(CPU)
    mean.find(gbuffer, sps_backwards(), by_pixel(irradiance))
    assert mean.value.numpy()[0] == pytest.approx(mean.samples.numpy().mean(), rel=1e-6)
    assert mean.samples.numpy().max() > 0.0

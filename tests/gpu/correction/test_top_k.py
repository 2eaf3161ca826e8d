"""Choosing some shading points of a list by keys."""

import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import column

from gpu.core.device import choose_device
from gpu.correction.top_k import LAST, Selection
from gpu.gbuffer.point_list import PointList


class Listed:
    """So many SPs of an image of 500 pixels, as ListedPoints."""

    def __init__(self, count: int, device: wp.Device) -> None:
        self.capacity = 500
        pixels = np.random.default_rng(0).permutation(self.capacity)
        arrays = column(pixels, int), column(np.arange(self.capacity) + 1000, int), column([count], int)
        self.pixels, self.numbers, self.count = (values.to(device) for values in arrays)
        self.points = PointList()
        self.points.pixels, self.points.numbers, self.points.count = self.pixels, self.numbers, self.count


@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("end", [40, int(LAST)])
@pytest.mark.parametrize(("capacity", "most"), [(1, 1), (64, 64), (500, 500), (500, 64), (64, 500)])
@pytest.mark.parametrize("count", [0, 1, 300, 500])
def test_those_of_the_smallest_keys_are_listed_in_the_order_of_the_list(
    count: int, capacity: int, most: int, end: int, name: str
) -> None:
    device = choose_device(name)
    points = Listed(count, device)
    keys = np.full(500, int(LAST))
    keys[:count] = np.random.default_rng(1).integers(0, 256, count)
    selection = Selection(points.capacity, capacity, end, device)
    if most != capacity:
        selection.limit(most)
    selection.keys.assign(keys.astype(np.int32))
    selection.choose(points)
    smallest = np.argsort(keys, kind="stable")[: min(capacity, most)]
    chosen = np.sort(smallest[keys[smallest] < end])
    assert selection.count.numpy()[0] == len(chosen)
    assert np.array_equal(selection.pixels.numpy()[: len(chosen)], points.pixels.numpy()[chosen])
    assert np.array_equal(selection.numbers.numpy()[: len(chosen)], points.numbers.numpy()[chosen])

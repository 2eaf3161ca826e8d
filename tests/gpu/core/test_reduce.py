import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.core import reduce as module
from gpu.core.reduce import PARTIALS, Counter


def test_sums_only_values_of_at_least_the_threshold() -> None:
    values = np.arange(3 * PARTIALS + 5)
    counter = Counter(3, wp.get_device("cpu"))
    arrays = column(values, wp.int32), column([7], wp.int32)
    counter.run([(arrays[0], 0), (arrays[0], 100), (arrays[1], 8)])
    assert counter.totals() == [values.sum(), values[values >= 100].sum(), 0]


def test_counts_values_beside_sums() -> None:
    values = column(np.tile([-1, 0, 5], PARTIALS), wp.int32)
    counter = Counter(3, wp.get_device("cpu"))
    counter.run([(values, 1)], [(values, -1), (values, 5)])
    assert counter.totals() == [5 * PARTIALS, PARTIALS, PARTIALS]
    counter.run([(values, 6)])
    assert counter.totals()[0] == 0


def test_all_rows_are_summed_up_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    launched: list[object] = []
    monkeypatch.setattr(module, "launch", lambda kernel, *_: launched.append(kernel))
    values, counter = column([1], wp.int32), Counter(16, wp.get_device("cpu"))
    counter.run([(values, 0)] * 15, [(values, 1)])
    assert launched == [module.sum_ints_kernel, module.fold_int_sums_kernel]

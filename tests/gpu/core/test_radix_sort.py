import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.core.radix_sort import Groups, running_total


@pytest.mark.parametrize(("count", "keys"), [(1, 1), (1000, 7), (5000, 8192)])
def test_groups_are_those_of_a_stable_sort(count: int, keys: int) -> None:
    rng = np.random.default_rng(count)
    wanted = rng.integers(0, keys + 1, count)  # the last belongs to no group
    groups = Groups(count, keys, wp.get_device("cpu"))
    groups.keys.assign(np.concatenate([wanted, np.zeros(count)]).astype(np.int32))
    groups.sort()
    items, starts = groups.items.numpy(), groups.starts.numpy()
    for key in range(keys):
        assert np.array_equal(items[starts[key] : starts[key + 1]], np.flatnonzero(wanted == key))
    assert starts[keys] == (wanted < keys).sum()


def test_items_of_a_group_follow_each_other_in_the_order_that_is_given() -> None:
    rng, count, keys = np.random.default_rng(0), 3000, 40
    wanted, order = rng.integers(0, keys + 1, count), rng.permutation(count)
    groups = Groups(count, keys, wp.get_device("cpu"))
    groups.keys.assign(np.concatenate([wanted, np.zeros(count)]).astype(np.int32))
    groups.sort(column(order, wp.int32))
    items, starts = groups.items.numpy(), groups.starts.numpy()
    for key in range(keys):
        assert np.array_equal(items[starts[key] : starts[key + 1]], order[wanted[order] == key])


def test_running_total_is_inclusive() -> None:
    totals = wp.zeros(4, dtype=int, device="cpu")
    running_total(column([1, 0, 2, 5], wp.int32), totals)
    assert totals.numpy().tolist() == [1, 1, 3, 8]

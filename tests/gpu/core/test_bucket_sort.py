import numpy as np
import pytest
import warp as wp
from devices import DEVICES

from gpu.core.bucket_sort import Buckets


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize(("items", "count", "shift"), [(1, 1, 0), (1000, 7, 0), (5000, 8192, 0), (3000, 5, 4)])
def test_items_of_a_bucket_are_sorted_by_key_and_number(items: int, count: int, shift: int, device: str) -> None:
    keys = np.random.default_rng(items).integers(0, count + 1 << shift, items)  # those of the last are of no bucket
    buckets = Buckets(items, count, wp.get_device(device), shift=shift)
    for wanted in (keys, keys[::-1]):  # nothing is left of what was sorted before
        buckets.keys.assign(wanted.astype(np.int32))
        buckets.sort()
        inside = int((wanted >> shift < count).sum())
        assert np.array_equal(buckets.items.numpy()[:inside], np.argsort(wanted, kind="stable")[:inside])
        assert np.array_equal(buckets.starts.numpy(), np.searchsorted(np.sort(wanted >> shift), range(count + 1)))

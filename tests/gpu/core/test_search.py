"""Binary search: NumPy's searchsorted, on every type and on columns of a table."""

from typing import Any

import numpy as np
import pytest
import warp as wp

from gpu.core.search import upper_bound

COUNT = 37


@wp.kernel
def search_kernel(values: wp.array[Any], count: int, sought: wp.array[Any], found: wp.array[int]) -> None:
    """One thread a value that is sought."""
    index = wp.tid()
    found[index] = upper_bound(values, count, sought[index])


@wp.kernel
def search_column_kernel(table: wp.array2d[float], column: int, sought: wp.array[float], found: wp.array[int]) -> None:
    """One thread a value that is sought in a column."""
    index = wp.tid()
    found[index] = upper_bound(table[:, column], table.shape[0], sought[index])


@pytest.mark.parametrize("dtype", [wp.int32, wp.uint32, wp.float32])
@pytest.mark.parametrize("count", [0, 1, COUNT])
def test_finds_the_first_above(dtype: Any, count: int, cpu: str) -> None:
    numbers = wp.dtype_to_numpy(dtype)
    values = np.sort(np.random.default_rng(1).integers(1, 30, COUNT)).astype(numbers)  # some are equal
    sought = np.arange(32).astype(numbers)
    found = wp.zeros(len(sought), dtype=int, device=cpu)
    inputs = [wp.array(values, dtype=dtype, device=cpu), count, wp.array(sought, dtype=dtype, device=cpu), found]
    wp.launch(search_kernel, dim=len(sought), inputs=inputs, device=cpu)
    assert found.numpy().tolist() == np.searchsorted(values[:count], sought, side="right").tolist()


def test_searches_a_column(cpu: str) -> None:
    rng = np.random.default_rng(2)
    table = np.cumsum(rng.random((COUNT, 3)), axis=0).astype(np.float32)
    sought = rng.uniform(0.0, table.max() + 1.0, 100).astype(np.float32)
    for column in range(3):
        found = wp.zeros(len(sought), dtype=int, device=cpu)
        inputs = [wp.array(table, device=cpu), column, wp.array(sought, device=cpu), found]
        wp.launch(search_column_kernel, dim=len(sought), inputs=inputs, device=cpu)
        assert found.numpy().tolist() == np.searchsorted(table[:, column], sought, side="right").tolist()

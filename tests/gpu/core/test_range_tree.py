import numpy as np
import pytest
import warp as wp

from gpu.core.range_tree import MOST_LEVELS, levels_of, run_begin


@wp.kernel
def begins_kernel(count: int, level: int, begins: wp.array[int]) -> None:
    begins[wp.tid()] = run_begin(count, level, wp.tid())


def begins_of(count: int, level: int) -> list[int]:
    """Where the runs of a level begin, and the last one ends."""
    begins = wp.zeros((1 << level) + 1, dtype=int, device="cpu")
    wp.launch(begins_kernel, len(begins), inputs=[count, level, begins], device="cpu")
    return begins.numpy().tolist()


@pytest.mark.parametrize(("capacity", "levels"), [(1, 0), (4, 0), (5, 1), (8, 1), (9, 2), (1 << 20, 18)])
def test_there_are_as_many_levels_as_items_need(capacity: int, levels: int) -> None:
    assert levels_of(capacity, 4) == levels < MOST_LEVELS


@pytest.mark.parametrize("count", [0, 1, 7, 64, 2_000_000_000])
def test_runs_share_the_items_evenly_and_children_those_of_their_parent(count: int) -> None:
    begins = begins_of(count, 3)
    sizes = np.diff(begins)
    assert begins[0] == 0
    assert begins[-1] == count
    assert sizes.max() - sizes.min() <= 1
    assert begins_of(count, 2) == begins[::2]

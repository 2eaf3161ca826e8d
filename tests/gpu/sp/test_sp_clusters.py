"""What a viewer keeps of its SP clusters."""

import pytest
import warp as wp

from gpu.clustering.grid import Grid
from gpu.sp.sp_clusters import KeptClusters


def numbers(kept: KeptClusters) -> tuple[int, ...]:
    budget = kept.budget
    return tuple(int(array.numpy()[0]) for array in (budget.wanted, budget.base, budget.max_new))


def test_a_quarter_is_kept_back_and_a_sixteenth_may_be_new_unless_all_at_once() -> None:
    kept = KeptClusters(Grid(800, wp.get_device("cpu")), 2)
    assert numbers(kept) == (800, 600, 51)
    kept.use(400)
    assert numbers(kept) == (400, 300, 26)
    assert kept.budget.spacing_scale.numpy()[0] == pytest.approx(2.0 / 300**0.5)
    kept.use(1000, at_once=True)
    assert numbers(kept) == (800, 600, 800)
    kept.use(1)
    assert numbers(kept) == (1, 1, 1)
    kept.forget()
    assert numbers(kept) == (1, 1, 1)
    kept.use(400)
    kept.forget()
    assert numbers(kept) == (400, 300, 400)
    assert kept.budget.extent.numpy()[0] == 400


def test_where_sps_are_nearer_clusters_are_as_far_apart_as_before() -> None:
    kept = KeptClusters(Grid(800, wp.get_device("cpu")), 2)
    kept.use(400)
    kept.spread(1)
    assert numbers(kept) == (400, 300, 26)
    assert kept.budget.spacing_scale.numpy()[0] == pytest.approx(1.0 / 300**0.5)

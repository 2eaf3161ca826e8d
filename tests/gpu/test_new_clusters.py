"""Clusters for SPs that others serve badly."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.kept_clusters import CROWDED
from gpu.new_clusters import FILLING, SERVICE, UNSERVED_NEED, WHOLE_NEED, NeedScale, drawn_sp, need_of
from gpu.scene.types import Doubles


@wp.kernel
def draw_kernel(first: int, totals: wp.array[int], count: int, number: int, out: wp.array[int]) -> None:
    """One thread a draw."""
    index = first + wp.tid()
    out[index] = drawn_sp(totals, count, index, number)


@wp.kernel
def need_kernel(first: int, scale: NeedScale, alike: bool, spacings: wp.array[float], out: wp.array[int]) -> None:
    """One thread a distance."""
    index = first + wp.tid()
    out[index] = need_of(scale, spacings[index], alike)


def drawn(need: list[int], number: int) -> list[int]:
    """The SPs that `number` draws fall on."""
    totals = column(np.cumsum(need), wp.int32)
    return [int(sp) for sp in results(draw_kernel, number, [totals, len(need), number], wp.int32)]


def test_draws_are_in_proportion_to_need() -> None:
    need = np.random.default_rng(0).integers(0, 9, 4000)
    taken = [sp for sp in drawn(need.tolist(), 500) if sp >= 0]
    assert len(taken) == len(set(taken)) == 500
    assert (need[taken] > 0).all()
    quarters = np.histogram(taken, bins=4, range=(0, 4000))[0]
    assert quarters == pytest.approx(500 * need.reshape(4, 1000).sum(axis=1) / need.sum(), abs=1.01)
    assert need[taken].mean() == pytest.approx((need**2).sum() / need.sum(), rel=0.1)


def test_an_sp_is_drawn_once_and_none_without_need() -> None:
    assert drawn([0, 5, 0, 100, 0], 10) == [3] + [-1] * 9
    assert drawn([50, 0, 50], 4) == [0, -1, 2, -1]
    assert drawn([0, 0, 0], 3) == [-1] * 3
    assert drawn([7], 2) == [0, -1]


def needs(scale: NeedScale, *, alike: bool = True) -> Doubles:
    distances = column([0.0, 0.74, 0.875, 1.0, 2.0, 100.0], float)
    return results(need_kernel, 6, [scale, alike, distances], wp.int32)


def test_need_grows_with_distance_up_to_a_bound() -> None:
    assert needs(SERVICE).tolist() == [0, 0, 0, 0, 16, 255]
    assert needs(SERVICE, alike=False).tolist() == needs(SERVICE).tolist()
    whole = int(WHOLE_NEED)
    assert needs(FILLING).tolist() == [0, 0, whole // 2, whole, whole, whole]
    assert needs(FILLING, alike=False).tolist() == [whole] * 6
    assert SERVICE.unserved == int(UNSERVED_NEED)
    assert FILLING.unserved > whole


def test_a_new_cluster_does_not_crowd_those_that_are_kept() -> None:
    assert FILLING.good > CROWDED

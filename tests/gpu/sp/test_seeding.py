"""Clusters for SPs that others serve badly."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.sp.seeding import drawn_sp


@wp.kernel
def draw_kernel(first: int, deficit_sums: wp.array[int], count: int, number: int, out: wp.array[int]) -> None:
    """One thread a draw."""
    index = first + wp.tid()
    out[index] = drawn_sp(deficit_sums, count, index, number)


def drawn(deficit: list[int], number: int) -> list[int]:
    """The SPs that `number` draws fall on."""
    sums = column(np.cumsum(deficit), wp.int32)
    return [int(sp) for sp in results(draw_kernel, number, [sums, len(deficit), number], wp.int32)]


def test_draws_are_in_proportion_to_deficit() -> None:
    deficit = np.random.default_rng(0).integers(0, 9, 4000)
    taken = [sp for sp in drawn(deficit.tolist(), 500) if sp >= 0]
    assert len(taken) == len(set(taken)) == 500
    assert (deficit[taken] > 0).all()
    quarters = np.histogram(taken, bins=4, range=(0, 4000))[0]
    assert quarters == pytest.approx(500 * deficit.reshape(4, 1000).sum(axis=1) / deficit.sum(), abs=1.01)
    assert deficit[taken].mean() == pytest.approx((deficit**2).sum() / deficit.sum(), rel=0.1)


def test_an_sp_is_drawn_once_and_none_without_deficit() -> None:
    assert drawn([0, 5, 0, 100, 0], 10) == [3] + [-1] * 9
    assert drawn([50, 0, 50], 4) == [0, -1, 2, -1]
    assert drawn([0, 0, 0], 3) == [-1] * 3
    assert drawn([7], 2) == [0, -1]

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.scene.types import Doubles
from gpu.vpl.group_sampling import GroupTable, groups_a_part, part_of, sample_group
from gpu.vpl.vpl_clusters import VplClusters


@wp.kernel
def row_kernel(first: int, table: GroupTable, column: int, picks: wp.array[float], out: wp.array[int]) -> None:
    """One thread a pick: the row that it falls into."""
    index = first + wp.tid()
    out[index] = part_of(table, column, picks[index])


@wp.kernel
def group_kernel(first: int, vpls: VplClusters, table: GroupTable,
                 picks: wp.array[float], out: wp.array[int]) -> None:  # fmt: skip
    """One thread a pick of column 0: the group that it falls into."""
    index = first + wp.tid()
    out[index] = sample_group(vpls, table, 0, picks[index])


@wp.kernel
def part_kernel(first: int, vpls: VplClusters, parts: int, out: wp.array[int]) -> None:
    """One thread: how many groups each part has."""
    out[first + wp.tid()] = groups_a_part(vpls, parts)


def table_of(importance: Doubles, cdf: Doubles) -> GroupTable:
    table = GroupTable()
    table.importance = wp.array(np.asarray(importance, np.float32), dtype=float, device="cpu")
    table.cdf = wp.array(np.asarray(cdf, np.float32), dtype=float, device="cpu")
    return table


def clusters_of(groups: int) -> VplClusters:
    clusters = VplClusters()
    clusters.groups = groups
    return clusters


def test_rows_are_found_by_their_running_totals_and_empty_ones_never() -> None:
    cdf = np.cumsum([[0.0, 9.0], [2.0, 9.0], [0.0, 9.0], [3.0, 9.0], [0.0, 9.0]], axis=0)
    picks = [0.0, 1.9, 2.0, 4.9, 5.0, 7.0]
    rows = results(row_kernel, len(picks), [table_of(cdf, cdf), 0, column(picks, float)], wp.int32)
    assert rows.tolist() == [1, 1, 3, 3, 3, 3]


@pytest.mark.parametrize(("groups", "parts"), [(13, 64), (64, 64), (300, 64), (1, 8)])
def test_groups_are_found_in_their_parts(groups: int, parts: int) -> None:
    """Also where a pick is all there is, by rounding, and most parts are empty."""
    rng = np.random.default_rng(groups)
    importance = rng.uniform(0.0, 1.0, (groups, 1)) * rng.integers(0, 2, (groups, 1))
    importance[groups // 2] = 1.0
    (each,) = results(part_kernel, 1, [clusters_of(groups), parts], wp.int32).astype(int)
    assert each * parts >= groups > (each - 1) * parts
    padded = np.zeros(parts * each)
    padded[:groups] = importance[:, 0]
    importance_cdf = np.cumsum(padded.reshape(parts, each).sum(axis=1)).astype(np.float32)
    ends = np.cumsum(importance[:, 0])
    lit = np.flatnonzero(importance[:, 0] > 0.0)
    picks = [*(ends[lit] - 0.5 * importance[lit, 0]), importance_cdf[-1], 1.1 * importance_cdf[-1]]
    inputs = [clusters_of(groups), table_of(importance, importance_cdf[:, None]), column(picks, float)]
    found = results(group_kernel, len(picks), inputs, wp.int32)
    assert found[:-2].tolist() == lit.tolist()
    assert ((found[-2:] >= lit[-1]) & (found[-2:] < groups)).all()

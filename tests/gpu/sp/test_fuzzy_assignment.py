"""How badly SPs are served."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results
from walking import budget_of
from walls import CPU, wall

from gpu.clustering.grid import Grid
from gpu.core.device import allocate
from gpu.gbuffer.point_list import PointList
from gpu.scene.types import Doubles
from gpu.sp.budget import SP_CLUSTER_PARAMETERS, WHOLE_DEFICIT, ClusterBudget
from gpu.sp.fuzzy_assignment import (
    DEFICIT_IN_FRAME,
    DEFICIT_TO_FILL,
    DeficitParameters,
    deficit_of,
    fuzzy_assignment_kernel,
)
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT, UNSERVED_DEFICIT, SpClusters


@wp.kernel
def deficit_kernel(first: int, scale: DeficitParameters, budget: ClusterBudget, alike: bool, distances: wp.array[float],
                   out: wp.array[int]) -> None:  # fmt: skip
    """One thread a distance."""
    index = first + wp.tid()
    out[index] = deficit_of(scale, budget, distances[index], alike)


def deficits(scale: DeficitParameters, *, alike: bool = True) -> Doubles:
    """Of SPs of a walk that accepts three quarters of a spacing."""
    distances = column([0.0, 0.74, 0.875, 1.0, 2.0, 100.0], float)
    return results(deficit_kernel, 6, [scale, budget_of(1, 0.75), alike, distances], wp.int32)


def test_deficits_grow_with_distance_up_to_a_bound() -> None:
    assert deficits(DEFICIT_IN_FRAME).tolist() == [0, 0, 0, 0, 16, 255]
    assert deficits(DEFICIT_IN_FRAME, alike=False).tolist() == deficits(DEFICIT_IN_FRAME).tolist()
    whole = int(WHOLE_DEFICIT)
    assert deficits(DEFICIT_TO_FILL).tolist() == [0, 0, whole // 2, whole, 2 * whole, 2 * whole]
    assert deficits(DEFICIT_TO_FILL, alike=False).tolist() == [2 * whole] * 6
    assert DEFICIT_TO_FILL.unserved == 8 * whole
    assert 255 < DEFICIT_IN_FRAME.unserved < int(UNASSIGNED_DEFICIT)


@pytest.mark.parametrize(("least_deficit", "cluster", "weight"), [(1, 4, 1.0), (0, 0, 0.0)])
def test_an_sp_far_from_all_takes_the_nearest_of_a_sample_when_the_needy_are_served(
    least_deficit: int, cluster: int, weight: float
) -> None:
    """Of 1000 clusters every fourth is looked at, about 256 in all; the second is nearest, then the fourth."""
    grid = Grid(1000, CPU)
    positions = np.tile(np.float32([5000.0, 0.0, 0.0]), (1000, 1))
    positions[[2, 4], 0] = 2000.0, 3000.0
    grid.data.position.assign(positions)
    grid.data.normal.assign(np.tile(np.float32([0.0, 0.0, 1.0]), (1000, 1)))
    grid.data.spacing.fill_(1.0)
    grid.build()
    points = PointList()
    points.pixels, points.count = column([0], wp.int32), column([1], wp.int32)
    out = allocate(SpClusters, 1, CPU, 6)
    out.serving, out.deficit = wp.zeros(1000, dtype=int, device=CPU), column([1], wp.int32)
    budget = budget_of(1000, 0.75, extent=1000)
    inputs = [0, wall(), points, grid.data, budget, SP_CLUSTER_PARAMETERS, DEFICIT_IN_FRAME, least_deficit, out]
    wp.launch(fuzzy_assignment_kernel(6, True), 1, inputs, device=CPU)
    assert out.deficit.numpy()[0] == int(UNSERVED_DEFICIT)
    assert out.cluster.numpy()[:, 0].tolist() == [cluster, 0, 0, 0, 0, 0]
    assert out.weight.numpy()[:, 0].tolist() == [weight, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert np.flatnonzero(out.serving.numpy()).tolist() == ([cluster] if least_deficit else [])


def test_an_sp_at_a_representative_leaves_a_thousandth_to_one_a_spacing_away() -> None:
    gbuffer, budget = wall(), budget_of(2, 0.75, extent=2)
    spacing = float(gbuffer.spacing.numpy()[0] * budget.spacing_scale.numpy()[0])
    grid = Grid(2, CPU)
    grid.data.position.assign(gbuffer.position.numpy()[0] + np.float32([[0.0, 0.0, 0.0], [spacing, 0.0, 0.0]]))
    grid.data.normal.assign(np.tile(gbuffer.normal.numpy()[0], (2, 1)))
    grid.data.spacing.fill_(spacing)
    grid.build()
    points = PointList()
    points.pixels, points.count = column([0], wp.int32), column([1], wp.int32)
    out = allocate(SpClusters, 1, CPU, 6)
    out.serving, out.deficit = wp.zeros(2, dtype=int, device=CPU), column([1], wp.int32)
    inputs = [0, gbuffer, points, grid.data, budget, SP_CLUSTER_PARAMETERS, DEFICIT_IN_FRAME, 0, out]
    wp.launch(fuzzy_assignment_kernel(6, True), 1, inputs, device=CPU)
    assert out.cluster.numpy()[:2, 0].tolist() == [0, 1]
    assert out.weight.numpy()[:2, 0] == pytest.approx([1000.0 / 1001.0, 1.0 / 1001.0], rel=1e-3)

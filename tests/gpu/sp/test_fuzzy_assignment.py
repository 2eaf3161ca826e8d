"""How badly SPs are served."""

import warp as wp
from scenes import column, results
from walking import budget_of

from gpu.scene.types import Doubles
from gpu.sp.budget import WHOLE_DEFICIT, ClusterBudget
from gpu.sp.fuzzy_assignment import DEFICIT_IN_FRAME, DEFICIT_TO_FILL, DeficitScale, deficit_of
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT


@wp.kernel
def deficit_kernel(first: int, scale: DeficitScale, budget: ClusterBudget, alike: bool, distances: wp.array[float],
                   out: wp.array[int]) -> None:  # fmt: skip
    """One thread a distance."""
    index = first + wp.tid()
    out[index] = deficit_of(scale, budget, distances[index], alike)


def deficits(scale: DeficitScale, *, alike: bool = True) -> Doubles:
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

"""Drawing one of the groups of VPL clusters in proportion to what they send, by tables of that."""

import warp as wp

from gpu.core.search import upper_bound
from gpu.sampling.sobol import BELOW_ONE
from gpu.vpl.vpl_clusters import VplClusters


@wp.func
def groups_a_part(vpls: VplClusters, parts: int) -> int:
    """How many groups each of so many parts has; the last parts may have fewer or none."""
    return (vpls.groups + parts - 1) // parts


@wp.func
def part_of(importance_cdf: wp.array2d[float], column: int, u: float) -> int:
    """The first row whose running total, in a column of `importance_cdf`, is above `u`; else the last that adds to
    it.
    """
    last = importance_cdf.shape[0] - 1
    return upper_bound(importance_cdf[:, column], last, wp.min(u, importance_cdf[last, column] * BELOW_ONE))


@wp.func
def sample_group(
    vpls: VplClusters, importance: wp.array2d[float], importance_cdf: wp.array2d[float], column: int, u: float
) -> int:
    """The group that `u`, from 0 to the last of a column's `importance_cdf`, falls into.

    mass (group, column): what each group sends; totals (part, column): the sum over the groups of a part and of those
    before it, more than 0 in the end.
    """
    part = part_of(importance_cdf, column, u)
    if part > 0:
        u -= importance_cdf[part - 1, column]
    groups = groups_a_part(vpls, importance_cdf.shape[0])
    group = part * groups
    end = wp.min(group + groups, vpls.groups)
    while group < end - 1 and u >= importance[group, column]:
        u -= importance[group, column]
        group += 1
    return group

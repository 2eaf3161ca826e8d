"""Drawing one of the groups of VPL clusters in proportion to what they send, by tables of that."""

import warp as wp

from gpu.vpl.vpl_clusters import VplClusters


@wp.func
def groups_a_part(vpls: VplClusters, parts: int) -> int:
    """How many groups each of so many parts has; the last parts may have fewer or none."""
    return (vpls.groups + parts - 1) // parts


@wp.func
def row_of(totals: wp.array2d[float], column: int, pick: float) -> int:
    """The first row whose running total, in a column of `totals`, is above `pick`; else the last that adds to it."""
    low = int(0)
    high = totals.shape[0] - 1
    whole = totals[high, column]
    while low < high:
        middle = (low + high) // 2
        total = totals[middle, column]
        if total > pick or total >= whole:
            high = middle
        else:
            low = middle + 1
    return low


@wp.func
def drawn_group(vpls: VplClusters, mass: wp.array2d[float], totals: wp.array2d[float], column: int, pick: float) -> int:
    """The group that `pick`, from 0 to the last of a column's `totals`, falls into.

    mass (group, column): what each group sends; totals (part, column): the sum over the groups of a part and of those
    before it, more than 0 in the end.
    """
    part = row_of(totals, column, pick)
    if part > 0:
        pick -= totals[part - 1, column]
    groups = groups_a_part(vpls, totals.shape[0])
    group = part * groups
    end = wp.min(group + groups, vpls.groups)
    while group < end - 1 and pick >= mass[group, column]:
        pick -= mass[group, column]
        group += 1
    return group

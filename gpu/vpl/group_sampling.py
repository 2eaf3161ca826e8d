"""Drawing VPL clusters in proportion to what they send: first a group of them by tables, then one of the group."""

import warp as wp

from gpu.core.device import launch
from gpu.core.search import upper_bound
from gpu.sampling.sobol import BELOW_ONE, TO_UNIT, hashed
from gpu.vpl.vpl_clusters import VplClusters, most_groups

# Tables are summed in parts, for a GPU's threads to share.
PARTS = 64


@wp.struct
class GroupTable:
    """What groups of VPL clusters send, a column each receiver.

    importance (group, column): what each group sends; cdf (part, column): the sum over the groups of a part
    (`groups_a_part`) and of those before it.
    """

    importance: wp.array2d[float]
    cdf: wp.array2d[float]


def group_table(vpl_count: int, columns: int, device: wp.Device) -> GroupTable:
    """A table for the groups that up to `vpl_count` VPL clusters form."""
    table = GroupTable()
    table.importance = wp.zeros((most_groups(vpl_count), columns), dtype=float, device=device)
    table.cdf = wp.zeros((PARTS, columns), dtype=float, device=device)
    return table


@wp.func
def groups_a_part(vpls: VplClusters, parts: int) -> int:
    """How many groups each of so many parts has; the last parts may have fewer or none."""
    return (vpls.groups + parts - 1) // parts


@wp.func
def column_total(table: GroupTable, column: int) -> float:
    """What all groups send together."""
    return table.cdf[table.cdf.shape[0] - 1, column]


@wp.kernel
def group_cdf_kernel(first: int, count: wp.array[int], table: GroupTable) -> None:
    """One thread each of the first count[0] columns: turns what each part sends into running totals."""
    column = first + wp.tid()
    if column >= count[0]:
        return
    total = float(0.0)
    for part in range(table.cdf.shape[0]):
        total += table.cdf[part, column]
        table.cdf[part, column] = total


def sum_parts(table: GroupTable, columns: int, count: wp.array) -> None:
    """Make `table.cdf` of what each part sends, in the first count[0] of `columns`."""
    launch(group_cdf_kernel, columns, [count, table], count.device)


@wp.func
def part_of(table: GroupTable, column: int, u: float) -> int:
    """The first part whose running total is above `u`; else the last that adds to it."""
    last = table.cdf.shape[0] - 1
    return upper_bound(table.cdf[:, column], last, wp.min(u, table.cdf[last, column] * BELOW_ONE))


@wp.func
def sample_group(vpls: VplClusters, table: GroupTable, column: int, u: float) -> int:
    """The group that `u`, from 0 to the column's total, falls into; the total must be more than 0."""
    part = part_of(table, column, u)
    if part > 0:
        u -= table.cdf[part - 1, column]
    groups = groups_a_part(vpls, table.cdf.shape[0])
    group = part * groups
    end = wp.min(group + groups, vpls.groups)
    while group < end - 1 and u >= table.importance[group, column]:
        u -= table.importance[group, column]
        group += 1
    return group


@wp.struct
class Reservoir:
    """One of the items offered so far, drawn in proportion to their weights. Start with `reservoir`.

    total: of all weights; item: −1 before any had a weight; weight: the item's; state: of the random numbers.
    """

    total: float
    item: int
    weight: float
    state: wp.uint32


@wp.func
def reservoir(state: wp.uint32) -> Reservoir:
    """An empty one, with the random numbers that follow `state`."""
    empty = Reservoir()
    empty.item = -1
    empty.state = state
    return empty


@wp.func
def offered(drawn: Reservoir, item: int, weight: float) -> Reservoir:
    """`drawn` after one more item (M. Chao, A General Purpose Unequal Probability Sampling Plan, 1982)."""
    drawn.total += weight
    drawn.state = hashed(drawn.state)
    if float(drawn.state) * TO_UNIT * drawn.total < weight:
        drawn.item = item
        drawn.weight = weight
    return drawn

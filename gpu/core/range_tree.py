"""A balanced binary tree over items in an order that keeps neighbours together, such as Morton's.

It has no pointers and one shape for a capacity, so it is made anew in each frame from the leaves up, a launch a level,
and its launches are the same whatever the items are. Nodes are numbered as in a heap: the root is 1, the children of n
are 2n and 2n + 1, and the last level's are the leaves. A node stands for an equal run of the items.
"""

import warp as wp

# Levels of the deepest tree.
MOST_LEVELS = 30


def levels_of(capacity: int, per_leaf: int) -> int:
    """How many levels there are below the root, so that a leaf has at most `per_leaf` of `capacity` items."""
    return max(-(-capacity // per_leaf) - 1, 0).bit_length()


@wp.func
def run_begin(count: int, level: int, number: int) -> int:
    """The first of `count` items that node `number`, 0 … 2^level, of a level stands for; its run ends where the next
    one's begins.
    """
    return int((wp.int64(number) * wp.int64(count)) >> wp.int64(level))


@wp.func
def run_holding(count: int, level: int, item: int) -> int:
    """The number of the node of a level whose run holds an item, one of `count`."""
    return int((((wp.int64(item) + wp.int64(1)) << wp.int64(level)) - wp.int64(1)) // wp.int64(count))

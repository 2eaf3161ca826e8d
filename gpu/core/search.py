"""Binary search in sorted arrays, such as cumulative distributions."""

from typing import Any

import warp as wp


@wp.func
def upper_bound(values: wp.array[Any], count: int, value: Any) -> int:
    """The first of the `count` leading elements that is above `value`, `count` if none is; values ascend.

    A column of a table is searched as table[:, column]. Integers: the first that is `value` or more is above value − 1.
    """
    low = int(0)
    high = int(count)
    while low < high:
        middle = (low + high) // 2
        if values[middle] > value:
            high = middle
        else:
            low = middle + 1
    return low

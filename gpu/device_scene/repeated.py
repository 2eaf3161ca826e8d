"""Which triangles lie in the place of others, corner on corner.

A ray that passes one passes all of them, whatever tree they are in: a million in one place, which are a file of a few
megabytes, take a ray as long as a million tests. One of them shows all that there is to see.
"""

import numpy as np
from numpy.typing import NDArray

from gpu.scene.types import Floats, Integers, Mask

_Hashes = NDArray[np.uint64]
_AT_ONCE = 1 << 20  # that are compared, for the memory it takes


def repeated(values: Floats, triangles: Integers, material: Integers) -> Mask:
    """Which of `triangles` (triangle, 3) equal an earlier one: the same material and corners, in the same sense.

    values (vertex, value): what of corners has to be equal, such as their positions; material (triangle,).
    """
    keys = _keys(values, triangles) + _mixed(material.astype(np.uint64))
    result = np.zeros(len(triangles), bool)
    ascending = np.sort(keys)
    if not (ascending[1:] == ascending[:-1]).any():
        return result
    order = np.argsort(keys, kind="stable")
    begins = np.ones(len(keys), bool)
    begins[1:] = keys[order[1:]] != keys[order[:-1]]
    firsts = order[np.maximum.accumulate(np.where(begins, np.arange(len(keys)), 0))]
    later, firsts = order[~begins], firsts[~begins]
    for start in range(0, len(later), _AT_ONCE):
        ones, others = later[start : start + _AT_ONCE], firsts[start : start + _AT_ONCE]
        result[ones] = _equal(values, triangles[ones], triangles[others]) & (material[ones] == material[others])
    return result


def _equal(values: Floats, ones: Integers, others: Integers) -> Mask:
    """Whether triangles have corners of equal values, from whichever corner on."""
    first = values[ones]
    turns = [(first == values[np.roll(others, turn, axis=1)]).all(axis=(1, 2)) for turn in range(3)]
    return np.asarray(np.logical_or.reduce(turns))


def _keys(values: Floats, triangles: Integers) -> _Hashes:
    """A number (triangle,) that is the same for triangles of equal corners, and rarely for others."""
    corner = np.zeros(len(values), np.uint64)
    for column in values.T:
        bits = (column + np.float32(0.0)).astype(np.float32).view(np.uint32)  # of -0 as of 0
        corner = _mixed(corner + bits)
    own = corner[triangles]
    return np.asarray(_mixed(np.uint64(3) * own + np.roll(own, -1, axis=1)).sum(axis=1, dtype=np.uint64))


def _mixed(number: _Hashes) -> _Hashes:
    """Each bit of the result depends on every bit: the steps of SplitMix64 (Steele, Lea, Flood 2014)."""
    number = number + np.uint64(0x9E3779B97F4A7C15)
    number = (number ^ (number >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    number = (number ^ (number >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return number ^ (number >> np.uint64(31))

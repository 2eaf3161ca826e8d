"""Importance warping: evenly spread points become points spread in proportion to an image (P. Clarberg et al., Wavelet
Importance Sampling, 2005). Line 6 of Algorithm 1 of the 2012 paper.

The image is a square of a power of two of pixels along each side, in Morton's order, so that each four that follow each
other are a square of the next coarser level.
"""

import numpy as np
import warp as wp

from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.sampling.halton import halton_point


@wp.struct
class ImportancePyramid:
    """Sums of an image's importance over squares of 4^level pixels, level after level.

    sums: level 0, the pixels, first; level l begins at starts[l] and ends where the next begins; `levels` above it, the
    last of one square. Squares beyond a level's last hold nothing.
    """

    levels: int
    starts: wp.array[int]
    sums: wp.array[float]


@wp.func
def sum_at(pyramid: ImportancePyramid, level: int, square: int) -> float:
    """The importance of a square."""
    place = pyramid.starts[level] + square
    if place >= pyramid.starts[level + 1]:
        return 0.0
    return pyramid.sums[place]


@wp.kernel
def pyramid_level_kernel(first: int, pyramid: ImportancePyramid, level: int) -> None:
    """One thread a square of a level: the sum of its four."""
    square = first + wp.tid()
    total = float(0.0)
    for quarter in range(4):
        total += sum_at(pyramid, level - 1, 4 * square + quarter)
    pyramid.sums[pyramid.starts[level] + square] = total


@wp.func
def rescaled(value: float, share: float) -> float:
    """Where a value of [0, 1) lies in the part of it below or above `share` that holds it, from 0 to 1."""
    if value < share:
        return value / share
    return (value - share) / wp.max(1.0 - share, 1.0 / FAR_AWAY)


@wp.func
def warped_pixel(pyramid: ImportancePyramid, point: wp.vec2) -> int:
    """The pixel that a point of the unit square goes to, row before column at each level; −1 if none has importance."""
    if sum_at(pyramid, pyramid.levels, 0) <= 0.0:
        return -1
    square = int(0)
    x = point[0]
    y = point[1]
    for step in range(pyramid.levels):
        level = pyramid.levels - 1 - step
        a = sum_at(pyramid, level, 4 * square)
        b = sum_at(pyramid, level, 4 * square + 1)
        c = sum_at(pyramid, level, 4 * square + 2)
        d = sum_at(pyramid, level, 4 * square + 3)
        upper = (a + b) / (a + b + c + d)
        row = wp.where(y < upper, 0, 1)
        y = rescaled(y, upper)
        left = wp.where(row == 0, a, c)
        both = wp.where(row == 0, a + b, c + d)
        share = left / both
        column = wp.where(x < share, 0, 1)
        x = rescaled(x, share)
        square = 4 * square + 2 * row + column
    return square


@wp.kernel
def warped_seed_kernel(first: int, pyramid: ImportancePyramid, shift: wp.vec2, seeds: wp.array[int]) -> None:
    """One thread a seed: the pixel that its shifted point of Halton's sequence goes to, −1 for none; seeds (seed,)."""
    seed = first + wp.tid()
    point = halton_point(seed) + shift
    seeds[seed] = warped_pixel(pyramid, wp.vec2(point[0] - wp.floor(point[0]), point[1] - wp.floor(point[1])))


class ImportanceWarp:
    """Spreads seeds over an image of up to atlas_side² pixels by their importance; its arrays are allocated once.

    importance (pixel,), which is not negative, is written by the caller. seed: of the points, which are those of
    Halton's sequence where it is 0, else shifted around the square (Cranley and Patterson 1976).
    """

    def __init__(self, pixels: int, atlas_side: int, device: wp.Device, seed: int = 0) -> None:
        self.device = device
        self._shift = wp.vec2(*(np.random.default_rng(seed).random(2) if seed else (0.0, 0.0)))
        self._sizes, levels = [pixels], atlas_side.bit_length() - 1
        for _ in range(levels):
            self._sizes.append(-(-self._sizes[-1] // 4))
        starts = [sum(self._sizes[:level]) for level in range(levels + 2)]
        self._pyramid = ImportancePyramid()
        self._pyramid.levels = levels
        self._pyramid.starts = wp.array(starts, dtype=int, device=device)
        self._pyramid.sums = wp.zeros(starts[-1], dtype=float, device=device)
        self.importance = self._pyramid.sums[:pixels]

    def run(self, seeds: wp.array) -> None:
        """Write the pixel of each of `seeds` (seed,), −1 for all where nothing has importance."""
        for level in range(1, len(self._sizes)):
            launch(pyramid_level_kernel, self._sizes[level], [self._pyramid, level], self.device)
        launch(warped_seed_kernel, len(seeds), [self._pyramid, self._shift, seeds], self.device)

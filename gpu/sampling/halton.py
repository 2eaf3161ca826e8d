"""Halton's sequence: points that fill the unit square evenly, however many are taken."""

import warp as wp

from gpu.sampling.sobol import BELOW_ONE


@wp.func
def radical_inverse(index: int, base: int) -> float:
    """The digits of `index` in a base, mirrored at the point."""
    value = float(0.0)
    digit = 1.0 / float(base)
    rest = int(index)
    while rest > 0:
        value += float(rest % base) * digit
        digit = digit / float(base)
        rest = rest // base
    return wp.min(value, BELOW_ONE)


@wp.func
def halton_point(index: int) -> wp.vec2:
    """Point `index` of the sequence of bases 2 and 3 (J. Halton 1960); the first, at the origin, is left out."""
    return wp.vec2(radical_inverse(index + 1, 2), radical_inverse(index + 1, 3))

"""Choices among a few candidates (Talbot et al., Importance Resampling for Global Illumination, 2005)."""

from typing import Any

import warp as wp


@wp.func
def candidate_at(weights: Any, place: float) -> int:
    """The candidate of a vector of weights, any of them above 0, that `place` along their sum lies in.

    Rounding may leave a rest at the end: the last candidate with any weight takes it.
    """
    rest = place
    chosen = int(-1)
    for candidate in range(len(weights)):
        if rest >= 0.0 and weights[candidate] > 0.0:
            chosen = candidate
            rest -= weights[candidate]
    return chosen

import numpy as np
import warp as wp
from scenes import results

from gpu.sampling.halton import halton_point


@wp.kernel
def halton_kernel(first: int, out: wp.array[wp.vec2]) -> None:
    """One thread a point."""
    index = first + wp.tid()
    out[index] = halton_point(index)


def test_points_are_halton_s() -> None:
    points = results(halton_kernel, 2592, [], wp.vec2)
    expected = [[1 / 2, 1 / 3], [1 / 4, 2 / 3], [3 / 4, 1 / 9], [1 / 8, 4 / 9], [5 / 8, 7 / 9]]
    assert np.allclose(points[:5], expected, atol=1e-6)
    # Of 2ᵃ·3ᵇ points that follow each other each cell of as many has one.
    cells = (points * [32, 81] + 1e-3).astype(int)
    assert len(np.unique(cells, axis=0)) == 2592

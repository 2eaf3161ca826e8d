import numpy as np
import warp as wp
from scenes import column, results

from gpu.core.kahan import Sum, kahan_add


@wp.kernel
def sum_kernel(first: int, terms: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:
    """One thread: all terms."""
    total = Sum()
    for place in range(terms.shape[0]):
        total = kahan_add(total, terms[place])
    out[first + wp.tid()] = total.total


def test_a_long_sum_is_the_rounded_exact_one() -> None:
    terms = np.random.default_rng(0).random((100_000, 3), np.float32) ** 4
    exact = terms.sum(axis=0, dtype=np.float64)
    assert np.allclose(results(sum_kernel, 1, [column(terms, wp.vec3)], wp.vec3)[0], exact, rtol=1.2e-7, atol=0.0)
    assert not np.allclose(np.cumsum(terms, axis=0)[-1], exact, rtol=1e-6, atol=0.0)  # so a plain one would fail

from dataclasses import dataclass

import pytest
import warp as wp
from scenes import results

from gpu.core.parameters import parameters


@wp.struct
@dataclass
class Parameters:
    """Two numbers."""

    scale: float = 3.0
    most: int = 7


@wp.kernel
def product_kernel(first: int, by: Parameters, out: wp.array[float]) -> None:
    """One thread."""
    out[first + wp.tid()] = by.scale * float(by.most)


def test_kernels_get_the_defaults_but_for_what_is_changed() -> None:
    assert results(product_kernel, 1, [parameters(Parameters)], float)[0] == 21.0
    assert results(product_kernel, 1, [parameters(Parameters, scale=2.0)], float)[0] == 14.0


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(TypeError, match="width"):
        parameters(Parameters, width=1.0)

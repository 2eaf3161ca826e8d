import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.core.device import launch
from gpu.indirect.spherical_harmonics import COUNT, Harmonics, harmonics_at

CPU = wp.get_device("cpu")


@wp.kernel
def harmonics_kernel(first: int, directions: wp.array[wp.vec3], out: wp.array[Harmonics]) -> None:
    index = first + wp.tid()
    out[index] = harmonics_at(directions[index])


def test_they_are_orthonormal() -> None:
    """Over the sphere, by a quadrature that is exact for products of two of them."""
    height, weight = np.polynomial.legendre.leggauss(8)
    turn = np.arange(16) * 2.0 * np.pi / 16.0
    z, angle = (grid.ravel() for grid in np.meshgrid(height, turn))
    radius = np.sqrt(1.0 - z**2)
    directions = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    out = wp.zeros(len(z), dtype=Harmonics, device=CPU)
    launch(harmonics_kernel, len(z), [column(directions, wp.vec3), out], CPU)
    values, weights = out.numpy(), np.tile(weight, 16) * 2.0 * np.pi / 16.0
    assert (values * weights[:, None]).T @ values == pytest.approx(np.eye(COUNT), abs=1e-5)

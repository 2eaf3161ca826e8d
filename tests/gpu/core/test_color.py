import pytest
import warp as wp
from scenes import column, results

from gpu.core.color import brightness


@wp.kernel
def brightness_kernel(first: int, radiance: wp.array[wp.vec3], out: wp.array[float]) -> None:
    """One thread a radiance."""
    index = first + wp.tid()
    out[index] = brightness(radiance[index])


def test_brightness_is_the_mean_of_the_channels() -> None:
    radiance = column([[0.0, 0.0, 0.0], [1.0, 2.0, 6.0], [6.0, 1.0, 2.0], [-3.0, 0.0, 0.0]], wp.vec3)
    assert results(brightness_kernel, 4, [radiance], float) == pytest.approx([0.0, 3.0, 3.0, -1.0])

import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.core.color import brightness, from_ycocg, to_ycocg


@wp.kernel
def brightness_kernel(first: int, radiance: wp.array[wp.vec3], out: wp.array[float]) -> None:
    """One thread a radiance."""
    index = first + wp.tid()
    out[index] = brightness(radiance[index])


def test_brightness_is_the_mean_of_the_channels() -> None:
    radiance = column([[0.0, 0.0, 0.0], [1.0, 2.0, 6.0], [6.0, 1.0, 2.0], [-3.0, 0.0, 0.0]], wp.vec3)
    assert results(brightness_kernel, 4, [radiance], float) == pytest.approx([0.0, 3.0, 3.0, -1.0])


@wp.kernel
def ycocg_kernel(first: int, colours: wp.array[wp.vec3], back: bool, out: wp.array[wp.vec3]) -> None:
    """One thread a colour: its luma and chroma, or `back` from these."""
    index = first + wp.tid()
    out[index] = from_ycocg(colours[index]) if back else to_ycocg(colours[index])


def test_grey_has_no_chroma_and_colours_come_back() -> None:
    colours = [[3.0, 3.0, 3.0], [1.0, 2.0, 6.0], [0.0, 1.0, 0.0]]
    parted = results(ycocg_kernel, 3, [column(colours, wp.vec3), False], wp.vec3)
    assert parted == pytest.approx(np.array([[3.0, 0.0, 0.0], [2.75, -2.5, -0.75], [0.5, 0.0, 0.5]]))
    assert results(ycocg_kernel, 3, [column(parted, wp.vec3), True], wp.vec3) == pytest.approx(np.array(colours))

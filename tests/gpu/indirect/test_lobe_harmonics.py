import numpy as np
import pytest
import warp as wp

from gpu.core.device import launch
from gpu.device_scene.bsdf import reflected
from gpu.device_scene.surface import Surface
from gpu.indirect.lobe_harmonics import lobe_harmonics, reflected_channel
from gpu.indirect.spherical_harmonics import Harmonics, harmonics_at
from gpu.sampling.warps import cone_direction

CPU = wp.get_device("cpu")
DIRECTIONS = 20_000
RADIANCE = (3.0, 0.7, -0.4, 0.9, 0.3, -0.2, 0.5, 0.4, -0.3, 0.2, 0.1, -0.2, 0.3, 0.1, -0.1, 0.2)


@wp.kernel
def lobe_kernel(first: int, radiance: Harmonics, roughness: float, views: wp.array[wp.vec3],
                out: wp.array2d[float]) -> None:  # fmt: skip
    """One thread a view: what is reflected by the projected lobe, and by the BRDF in many directions."""
    index = first + wp.tid()
    surface = Surface()
    surface.normal = wp.vec3(0.0, 1.0, 0.0)
    surface.geometric_normal = surface.normal
    surface.f0 = wp.vec3(0.5, 0.5, 0.5)
    surface.f90 = 1.0
    surface.roughness = roughness
    view = views[index]
    out[index, 0] = reflected_channel(lobe_harmonics(surface, view), 0.5, 1.0, radiance)
    total = float(0.0)
    for number in range(DIRECTIONS):
        turn = 0.6180339887 * float(number)
        x = (float(number) + 0.5) / float(DIRECTIONS)
        direction = cone_direction(surface.normal, 0.0, x, turn - wp.floor(turn))
        total += reflected(surface, view, direction)[0] * wp.dot(radiance, harmonics_at(direction))
    out[index, 1] = total * 2.0 * wp.pi / float(DIRECTIONS)


@pytest.mark.parametrize("roughness", [0.3, 0.45])
def test_a_projected_lobe_reflects_what_the_brdf_does(roughness: float) -> None:
    angle = np.radians([5.0, 30.0, 55.0, 75.0])
    views = np.stack([np.sin(angle), np.cos(angle), np.zeros(4)], axis=1)
    out = wp.zeros((4, 2), dtype=float, device=CPU)
    launch(lobe_kernel, 4, [Harmonics(*RADIANCE), roughness, wp.array(views, dtype=wp.vec3, device=CPU), out], CPU)
    told, wanted = out.numpy().T
    assert told == pytest.approx(wanted, rel=0.05)

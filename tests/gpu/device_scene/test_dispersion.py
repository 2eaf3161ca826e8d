"""Glass that refracts each colour otherwise: its indices, and that paths through it lose and gain no light."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from pictures import picture
from scenes import box, resident_of, results

from gpu.device_scene.dispersion import disperses, of_channel, refracting
from gpu.device_scene.surface import MIN_IOR, Surface
from gpu.scene.camera import look_at
from gpu.scene.types import Material, Sky
from gpu.settings import Method


@wp.kernel
def index_kernel(first: int, eta: float, dispersion: float, out: wp.array[wp.vec4]) -> None:
    """One thread a channel: the index over the other side's, and the light of it."""
    channel = first + wp.tid()
    surface = Surface()
    surface.glass = 1.0
    surface.eta = eta
    surface.dispersion = dispersion
    light = of_channel(wp.vec3(1.0, 2.0, 3.0), channel)
    index = float(0.0)
    if disperses(surface):
        index = refracting(surface, channel).eta
    out[channel] = wp.vec4(index, light[0], light[1], light[2])


def test_indices_are_those_of_the_extension() -> None:
    """(n − 1) / Abbe number between red and blue, of which 20 / Abbe number is the dispersion."""
    outer = results(index_kernel, 3, [1.5, 2.0], wp.vec4)
    assert outer[:, 0] == pytest.approx([1.475, 1.5, 1.525], rel=1e-6)
    assert np.array_equal(outer[:, 1:], np.diag([3.0, 6.0, 9.0]))
    inner = results(index_kernel, 3, [1.0 / 1.5, 2.0], wp.vec4)
    assert inner[:, 0] == pytest.approx(1.0 / outer[:, 0], rel=1e-6)
    assert not results(index_kernel, 3, [1.5, 0.0], wp.vec4)[:, 0].any()


@pytest.mark.parametrize("dispersion", [60.0, 120.0, 1e6])
def test_no_index_is_less_than_that_of_air(dispersion: float) -> None:
    outer, inner = (results(index_kernel, 3, [eta, dispersion], wp.vec4)[:, 0] for eta in (1.5, 1.0 / 1.5))
    assert outer[0] == pytest.approx(MIN_IOR, rel=1e-6)
    assert inner == pytest.approx(1.0 / outer, rel=1e-6)


def test_paths_in_one_colour_bring_as_much_light_as_all() -> None:
    glass = Material(transmission=1.0, roughness=0.0, thickness=1.0)
    faces = [replace(part, triangles=part.triangles[:, ::-1]) for part in box()]
    camera = look_at((1.1, 0.9, 1.4), (0.0, 0.0, 0.0), yfov_degrees=50.0)
    white, coloured = (
        picture(resident_of(faces, [it], sky=Sky((1.0, 1.0, 1.0))), camera, method=Method.PATH, samples=64, bounces=8)
        for it in (glass, replace(glass, dispersion=5.0))
    )
    assert np.ptp(coloured, axis=2).max() > 0.02 > np.ptp(white, axis=2).max()
    assert coloured.mean(axis=(0, 1)) == pytest.approx(white.mean(axis=(0, 1)), rel=0.02)

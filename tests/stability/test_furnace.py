"""Closed rooms whose radiance is known in closed form."""

import numpy as np
import pytest
from scenes import box, grey, resident_of
from stress import render
from trimesh.creation import icosphere

from gpu.sample_counts import ON_CPU
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Light, LightKind
from gpu.settings import Method

SIZE = (16, 12)
# As many bounces as there can be: what comes after is 0.7¹⁸, two parts in a thousand.
COUNTS = {
    "bounces": 16,
    "samples": 16,
    "vpls": ON_CPU.vpls,
    "vpl_clusters": ON_CPU.vpl_clusters,
    "sp_clusters": ON_CPU.sp_clusters,
}


def reflected(albedo: float, method: Method) -> float:
    """How many times as bright reflections make what is alike all over: 1 + ρ + ρ² + …, as far as a method has them."""
    return 1.0 + albedo + albedo**2 if method is Method.RSM_DISKS else 1.0 / (1.0 - albedo)


@pytest.mark.parametrize("method", list(Method))
def test_a_closed_grey_box(device: str, method: Method) -> None:
    """Every wall emits Le and reflects ρ, so radiance is Le / (1 − ρ) all over."""
    emission, albedo = 3.0, 0.7
    device_scene = resident_of(box(), [grey(albedo, emission)], device=device)
    picture = render(
        device_scene, look_at((0.2, 0.1, 0.3), (-0.3, -0.2, -0.4), yfov_degrees=80.0), SIZE, method=method, **COUNTS
    )
    assert picture.mean() == pytest.approx(emission * reflected(albedo, method), rel=0.025)


@pytest.mark.parametrize("method", list(Method))
@pytest.mark.parametrize("lit", ["a bulb in the middle", "itself"])
def test_pbrts_sphere(device: str, lit: str, method: Method) -> None:
    """A unit sphere that reflects one half, lit by one half from inside: radiance 1. A bulb's light is reflected once
    before it is alike all over.

    Source: analytic scenes of pbrt-v4's integrators_test.cpp.
    """
    bulb = Light("bulb", LightKind.POINT, (np.pi, np.pi, np.pi))
    material, lights = (grey(0.5, 0.5), []) if lit == "itself" else (grey(0.5), [bulb])
    ball = icosphere(4, 1.0)
    part = MeshPart(ball.vertices, ball.faces[:, ::-1])
    device_scene = resident_of([part], [material], lights=lights, device=device)
    picture = render(
        device_scene, look_at((0.1, 0.2, 0.3), (0.0, 0.0, -1.0), yfov_degrees=45.0), SIZE, method=method, **COUNTS
    )
    expected = 0.5 * reflected(0.5, method) if lit == "itself" or method is not Method.RSM_DISKS else 0.5 + 0.25
    assert picture.mean() == pytest.approx(expected, abs=0.03)

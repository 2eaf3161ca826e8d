import numpy as np
import pytest
import warp as wp
from scenes import box, column, grey, quad, resident_of

from gpu.vpl.vpl_reflectance import find_reflectance


def test_vpls_reflect_what_their_surface_does_on_their_side() -> None:
    parts = [*box(0), quad((-0.2, 0.0, -0.2), (0.0, 0.0, 0.4), (0.4, 0.0, 0.0), 1)]
    device_scene = resident_of(parts, [grey(0.3), grey(0.8)])
    places = np.array([[0.1, -0.5, 0.1], [0.1, 0.0, 0.1], [-0.1, 0.0, 0.1], [0.1, 0.2, 0.1]])
    normals = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    reflectance = wp.zeros(4, dtype=wp.vec3, device=device_scene.device)
    features = device_scene.features(lambertian=False)
    find_reflectance(device_scene.data, features, column(places, wp.vec3), column(normals, wp.vec3), reflectance)
    assert reflectance.numpy() == pytest.approx(np.array([[0.3] * 3, [0.8] * 3, [0.8] * 3, [0.0] * 3]))

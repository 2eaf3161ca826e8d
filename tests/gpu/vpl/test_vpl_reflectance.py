from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import box, column, grey, quad, resident_of

from gpu.scene.types import AlphaMode
from gpu.vpl.vpl_reflectance import find_reflectance


def test_vpls_reflect_what_their_surface_does_on_their_side() -> None:
    parts = [*box(0), quad((-0.2, 0.0, -0.2), (0.0, 0.0, 0.4), (0.4, 0.0, 0.0), 1)]
    device_scene = resident_of(parts, [grey(0.3), grey(0.8)])
    places = np.array([[0.1, -0.5, 0.1], [0.1, 0.0, 0.1], [-0.1, 0.0, 0.1], [0.1, 0.2, 0.1]])
    normals = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    reflectance = wp.zeros(4, dtype=wp.vec3, device=device_scene.device)
    features, nobody = device_scene.features(lambertian=False), wp.zeros(0, dtype=float, device=device_scene.device)
    find_reflectance(
        device_scene.data, features, column(places, wp.vec3), column(normals, wp.vec3), reflectance, nobody
    )
    assert reflectance.numpy() == pytest.approx(np.array([[0.3] * 3, [0.8] * 3, [0.8] * 3, [0.0] * 3]))


def test_the_share_of_a_surface_that_is_there_is_told_and_its_reflectance_is_that_of_all() -> None:
    veil = replace(grey(0.8), base_color=(0.8, 0.8, 0.8, 0.2), alpha_mode=AlphaMode.BLEND)
    device_scene = resident_of(
        [*box(0), quad((-0.2, 0.0, -0.2), (0.0, 0.0, 0.4), (0.4, 0.0, 0.0), 1)], [grey(0.3), veil]
    )
    places, up = column([[0.1, 0.0, 0.1], [0.1, -0.5, 0.1]], wp.vec3), column([[0.0, 1.0, 0.0]] * 2, wp.vec3)
    reflectance, share = (wp.zeros(2, kind, device=device_scene.device) for kind in (wp.vec3, float))
    features = device_scene.features(lambertian=False)
    find_reflectance(device_scene.data, features, places, up, reflectance, share)
    assert reflectance.numpy()[:, 0] == pytest.approx([0.8, 0.3])
    assert share.numpy() == pytest.approx([0.2, 1.0])

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import box, column, grey, quad, resident_of, results

from gpu.scene.types import AlphaMode
from gpu.vpl.vpl_reflectance import VplReflectance, find_reflectance, reflectance_of_side


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


@wp.kernel
def side_kernel(first: int, both: VplReflectance, choices: wp.array[float], out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    side = reflectance_of_side(both, choices[index])
    out[3 * index] = side.even
    out[3 * index + 1] = side.spread
    out[3 * index + 2] = side.through


def test_in_the_mean_both_sides_of_what_is_translucent_send_what_they_do() -> None:
    both = VplReflectance()
    both.even, both.spread, both.through = wp.vec3(0.8, 0.5, 0.4), wp.vec3(0.7, 0.5, 0.4), wp.vec3(0.4, 0.2, 0.1)
    choices = column((np.arange(1000) + 0.5) / 1000, float)
    found = results(side_kernel, 1000, [both, choices], wp.vec3, width=3)
    even, spread, through = (found[place::3] for place in range(3))
    assert even.mean(axis=0) == pytest.approx([0.8, 0.5, 0.4], rel=2e-3)
    assert spread.mean(axis=0) == pytest.approx([0.7, 0.5, 0.4], rel=2e-3)
    behind = through[:, 0] > 0.0
    assert behind.mean() == pytest.approx(0.5, abs=2e-3)
    assert (even[behind] == through[behind]).all()

from dataclasses import replace

import numpy as np
from glass import GLASS, MIRROR
from scenes import grey, quad, resident_of

from gpu.lights.caustic_casters import caustic_casters

MATERIALS = [grey(0.5), MIRROR, GLASS, replace(MIRROR, roughness=0.2), replace(GLASS, roughness=0.5)]


def test_mirrors_and_clear_glass_cast_caustics_by_their_area() -> None:
    parts = [quad([0.2 * k, 0, 0], [0.1, 0, 0], [0, 0.1 + 0.1 * k, 0], k) for k in range(5)]
    device_scene = resident_of(parts, MATERIALS)
    casters = caustic_casters(device_scene)
    faces = casters.faces.numpy()
    materials = device_scene.scene.triangle_material[device_scene.triangle_order[faces]]
    assert sorted(materials) == [1, 1, 2, 2]
    scale = device_scene.scene.placement.scale
    assert np.allclose(casters.areas.numpy(), (0.1 + 0.1 * materials) * 0.05 * scale**2, rtol=1e-5)
    shares = np.diff(np.append(0.0, casters.choice.cumulative.numpy() / 2**32))
    assert np.allclose(shares, (1 + materials) / 10.0, atol=1e-6)


def test_where_there_are_none_there_is_no_choice() -> None:
    assert caustic_casters(resident_of([quad([0, 0, 0], [1, 0, 0], [0, 1, 0])], [grey(0.5)])).choice.count == 0

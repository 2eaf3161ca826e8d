import numpy as np
from builtin_scenes import scene_of, world_corners


def test_the_cornell_box_has_its_measures() -> None:
    scene = scene_of("cornell-box")
    np.testing.assert_allclose(np.ptp(world_corners(scene), axis=(0, 1)), (0.556, 0.5488, 0.5592), atol=1e-6)
    colours = {material.name: material.base_color[:3] for material in scene.materials}
    corners = world_corners(scene)
    middle = {m.name: corners[scene.triangle_material == n].mean(axis=(0, 1)) for n, m in enumerate(scene.materials)}
    assert middle["red"][0] < 0.0 < middle["green"][0]  # red on the left of the camera, which looks along −Z
    assert colours["red"][0] > 4.0 * colours["red"][1]
    assert 0.5 < middle["light"][1] < 0.5488

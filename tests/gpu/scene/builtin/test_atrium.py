import numpy as np
from builtin_scenes import nearest_hit, scene_of, world_corners


def test_the_sun_reaches_the_court_of_the_atrium() -> None:
    scene = scene_of("atrium")
    corners = world_corners(scene)
    towards = -np.array(scene.lights[0].direction)
    assert nearest_hit(corners, np.array([2.0, 0.2, -2.5]), towards)[0] == np.inf
    assert nearest_hit(corners, np.array([2.0, 0.2, 5.5]), towards)[0] < np.inf  # the south walk lies in the shade
    assert scene.sky is not None

import numpy as np
from scenes import grey, quad, scene_of

from gpu.scene.lighting.surroundings import EVEN, surrounded
from gpu.scene.types import Light, LightKind, Sky

FLOOR = quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0])


def test_a_picture_around_takes_the_place_of_a_sky_and_of_what_was_added() -> None:
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    lit, dark = scene_of([FLOOR], [grey(0.5)], [sun], Sky((1.0, 1.0, 1.0))), scene_of([FLOOR], [grey(0.5)])
    assert dark.sky is not None
    for scene, lights in ((lit, (sun,)), (dark, ())):
        found = surrounded(scene, EVEN)
        assert found.sky is EVEN
        assert found.lights == lights
        assert np.array_equal(found.triangles, scene.triangles)
    assert len(surrounded(dark, EVEN).report.notes) == len(dark.report.notes) - 1

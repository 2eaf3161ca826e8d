from dataclasses import replace

import numpy as np
from scenes import box, grey, quad, scene_of

from gpu.scene.types import Camera

CAMERA = Camera("a", np.eye(4), 0.5)


def test_cameras_that_see_the_same_have_one_key_whatever_their_name_and_aspect() -> None:
    assert replace(CAMERA, name="b", aspect=1.0, to_world=np.eye(4)).view_key == CAMERA.view_key


def test_cameras_that_see_otherwise_have_other_keys() -> None:
    moved = np.eye(4)
    moved[0, 3] = 1e-9
    others = [
        replace(CAMERA, to_world=moved),
        replace(CAMERA, half_height=0.6),
        replace(CAMERA, orthographic=True),
        replace(CAMERA, near=0.1),
    ]
    assert len({camera.view_key for camera in (CAMERA, *others)}) == 5


def test_a_scene_in_other_light_knows_how_many_triangles_each_material_has() -> None:
    scene = scene_of([*box(0), quad((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), 1)], [grey(0.5), grey(0.2)])
    lit = scene.relit((grey(0.1), grey(0.3)), (), None)
    assert (lit.materials, lit.lights, lit.sky) == ((grey(0.1), grey(0.3)), (), None)
    assert lit.material_triangles is scene.material_triangles
    assert lit.material_triangles.tolist() == [12, 2]

import numpy as np
from builtin_scenes import face_normals, scene_of, world_corners


def test_the_torus_is_inside_of_closed_glass() -> None:
    scene = scene_of("glass-box")
    names = [material.name for material in scene.materials]
    corners = {name: world_corners(scene)[scene.triangle_material == n] for n, name in enumerate(names)}
    glass, torus = corners["glass"], corners["torus"]
    normals = face_normals(glass)
    # Behind every face of the cube: its front is outside, and nothing sticks out.
    depth = np.einsum("fc,fpc->fp", normals, glass[:, :1] - torus.reshape(1, -1, 3))
    assert depth.min() > 0.005
    area = np.linalg.norm(np.cross(glass[:, 1] - glass[:, 0], glass[:, 2] - glass[:, 0]), axis=1) / 2
    assert np.allclose(area @ normals, 0.0, atol=1e-9)
    assert glass[..., 1].min() > 0.0

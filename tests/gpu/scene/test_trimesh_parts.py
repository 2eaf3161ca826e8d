"""Mesh parts as trimesh reads them: attributes as the files have them, and its errors as the project's own."""

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.trimesh_parts import load_parts

PLY = b"""ply\nformat ascii 1.0\nelement vertex 3
property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz
property uchar red\nproperty uchar green\nproperty uchar blue
element face 1\nproperty list uchar int vertex_indices\nend_header
0 0 0 0 0 2 255 188 0
1 0 0 0 0 2 255 188 0
1 1 0 0 0 2 255 188 0
3 0 1 2
"""
OBJ = b"""v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0\nvt 0 1
g 4\nusemtl 4\nf 1/1 2/2 3/3\ng 7\nusemtl 7\nf 1/1 3/3 2/2
"""


def test_the_colours_of_vertices_become_linear() -> None:
    (part,) = load_parts("scene.ply", PLY, "ply", shaded=True)
    assert part.colors is not None
    assert np.allclose(part.colors, (1.0, 0.503, 0.0, 1.0), atol=1e-3)
    assert (part.material, part.uvs, part.triangles.tolist()) == (0, (), [[0, 1, 2]])


def test_normals_are_those_of_the_file_where_it_has_any() -> None:
    (part,) = load_parts("scene.ply", PLY, "ply", shaded=True)
    assert part.normals is not None
    assert np.allclose(part.normals / np.linalg.norm(part.normals, axis=1)[:, None], (0.0, 0.0, 1.0))
    assert load_parts("scene.ply", PLY, "ply", shaded=False)[0].normals is None


@pytest.mark.parametrize(("flip_v", "expected"), [(False, [0.25, 0.0, 1.0]), (True, [0.75, 1.0, 0.0])])
def test_groups_named_by_numbers_have_these_materials(flip_v: bool, expected: list[float]) -> None:
    found = load_parts("scene.obj", OBJ, "obj", False, flip_v, split_groups=True, skip_materials=True)
    parts = sorted(found, key=lambda part: part.name)
    assert [(part.name, part.material) for part in parts] == [("4", 4), ("7", 7)]
    (uvs,) = parts[0].uvs
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    v = [uvs[np.argmin(np.abs(parts[0].positions - corner).sum(axis=1)), 1] for corner in corners]
    assert v == pytest.approx(expected)


@pytest.mark.parametrize("content", [b"", PLY[:200], PLY.replace(b"vertex 3", b"vertex -4")])
def test_what_trimesh_raises_is_an_error_of_the_scene(content: bytes) -> None:
    with pytest.raises(SceneError, match=r"scene\.ply: not a PLY file that can be read"):
        load_parts("scene.ply", content, "ply", shaded=False)

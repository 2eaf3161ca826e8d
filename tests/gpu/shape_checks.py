"""What tests ask of shapes under construction."""

import numpy as np

from gpu.scene.builtin.shape import Shape


def volume(shape: Shape) -> float:
    """The volume that the fronts enclose (divergence theorem): negative when they face inwards."""
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    return float(np.einsum("tc,tc->t", a, np.cross(b, c)).sum() / 6.0)


def agreement(shape: Shape) -> float:
    """The least cosine between a face's normal and those of its corners."""
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    faces = np.cross(b - a, c - a)
    faces /= np.linalg.norm(faces, axis=1)[:, None]
    return float(np.einsum("tkc,tc->tk", shape.normals[shape.triangles], faces).min())

"""Tangents of vertices (TANGENT), as far as anisotropy needs them: by how much they turn its directions from the UVs'.

Where UVs tell directions as well, as those of normal maps do, tangents say nothing new and are not read.
"""

import numpy as np

from gpu.scene.formats.gltf.primitives import Primitive
from gpu.scene.types import Doubles

_PLAIN = np.radians(1.0)  # as far as nobody sees it
_TOGETHER = 0.9  # of the mean of directions in length, from which on it stands for them


def turn_of(primitive: Primitive, uv_set: int) -> tuple[float, bool]:
    """The mean angle [rad], counter-clockwise from where u of a UV set grows, of a primitive's tangents, 0 where it has
    none or no UVs or where nobody sees it; and whether it stands for all of them. Directions have no sign.
    """
    attributes, corners = primitive.attributes, primitive.triangles
    uvs, tangents = attributes.get(f"TEXCOORD_{uv_set}"), attributes.get("TANGENT")
    if uvs is None or tangents is None:
        return 0.0, True
    a, b, c = (attributes["POSITION"][corners[:, k]] for k in range(3))
    uv_a, uv_b, uv_c = (uvs[corners[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    (du1, dv1), (du2, dv2) = (uv_b - uv_a).T, (uv_c - uv_a).T
    mirrored = np.sign(du1 * dv2 - dv1 * du2)[:, None]
    along = _unit(((b - a) * dv2[:, None] - (c - a) * dv1[:, None]) * mirrored)
    across = np.cross(_unit(normal), along) * -mirrored  # glTF's bitangent, against v
    shown = tangents[corners, :3].mean(axis=1)
    x, y = np.sum(shown * along, axis=1), np.sum(shown * across, axis=1)
    doubled = _unit(np.stack([x * x - y * y, 2.0 * x * y], axis=1)) * np.linalg.norm(normal, axis=1)[:, None]
    lengths = np.linalg.norm(doubled, axis=1).sum()
    mean = doubled.sum(axis=0)
    if lengths == 0.0:
        return 0.0, True
    turn = float(np.arctan2(mean[1], mean[0]) / 2.0)
    return turn if abs(turn) > _PLAIN else 0.0, bool(np.linalg.norm(mean) >= _TOGETHER * lengths)


def _unit(vectors: Doubles) -> Doubles:
    """Unit vectors (vector, …), zero where they have no length."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)

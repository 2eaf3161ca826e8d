"""4×4 column-vector matrices from a file's spaces to its world, and mesh parts placed by them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gpu.scene.assemble import MeshPart
from gpu.scene.types import Doubles, Mask

LEAST_QUATERNION = 1e-6  # its length; shorter ones have no direction


def placed(part: MeshPart, matrices: Doubles, names: Sequence[str] = ()) -> MeshPart:
    """`part` once for each of `matrices` (instance, 4, 4), its fronts outside under those that mirror.

    names: of the objects that its instances are, where these are not all that of `part`.
    """
    count, vertices = len(matrices), len(part.positions)
    triangles = np.repeat(part.triangles[None], count, axis=0) + np.arange(count)[:, None, None] * vertices
    flipped = mirrored(matrices)
    triangles[flipped] = triangles[flipped][:, :, ::-1]
    world = np.einsum("nij,vj->nvi", matrices[:, :3, :3], part.positions) + matrices[:, None, :3, 3]
    normals = part.normals
    if normals is not None:
        normals = np.einsum("nij,vj->nvi", cofactors(matrices), normals).reshape(-1, 3)
    return replace(
        part,
        positions=world.reshape(-1, 3),
        triangles=triangles.reshape(-1, 3),
        normals=normals,
        uvs=tuple(np.tile(np.asarray(uv, np.float64), (count, 1)) for uv in part.uvs),
        colors=None if part.colors is None else np.tile(np.asarray(part.colors, np.float64), (count, 1)),
        objects=tuple(names) or part.objects,
        vertex_object=np.repeat(np.arange(count), vertices) if names else None,
    )


def compose(translation: Doubles, rotation: Doubles, scale: Doubles) -> Doubles:
    """Matrices (row, 4, 4) = T·R·S from rows of translations, quaternions (x, y, z, w) of any length, and scales.

    A quaternion without a direction turns nothing.
    """
    length = np.linalg.norm(rotation, axis=1)[:, None]
    directed = length >= LEAST_QUATERNION
    x, y, z, w = np.where(directed, rotation / np.where(directed, length, 1.0), (0.0, 0.0, 0.0, 1.0)).T
    matrices = np.zeros((len(translation), 4, 4))
    matrices[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1)
    matrices[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1)
    matrices[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1)
    matrices[:, :3, :3] *= scale[:, None, :]
    matrices[:, :3, 3] = translation
    matrices[:, 3, 3] = 1.0
    return matrices


def rigid(matrix: Doubles) -> Doubles:
    """`matrix` (4, 4) without scale, shear or mirroring: same origin, same −Z, +Y as near as possible."""
    backward = _unit(matrix[:3, 2], np.array([0.0, 0.0, 1.0]))
    helper = np.eye(3)[int(np.argmin(np.abs(backward)))]
    right = _unit(np.cross(matrix[:3, 1], backward), _unit(np.cross(helper, backward), helper))
    result = np.eye(4)
    result[:3, :3] = np.stack([right, np.cross(backward, right), backward], axis=1)
    result[:3, 3] = matrix[:3, 3]
    return result


def cofactors(matrices: Doubles) -> Doubles:
    """What turns normals under `matrices` (matrix, 4, 4): inverse transpose times |determinant|, (matrix, 3, 3).

    Defined for singular matrices too.
    """
    x, y, z = (matrices[:, :3, column] for column in range(3))
    turned = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=2)
    return turned * np.where(mirrored(matrices), -1.0, 1.0)[:, None, None]


def mirrored(matrices: Doubles) -> Mask:
    """Which of the matrices (matrix, 4, 4) turn counter-clockwise into clockwise."""
    return np.asarray(np.linalg.det(matrices[:, :3, :3]) < 0.0)


def _unit(vector: Doubles, otherwise: Doubles) -> Doubles:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-12 else otherwise

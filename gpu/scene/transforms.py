"""4×4 column-vector matrices from a file's spaces to its world, and mesh parts placed by them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Mask

AT_ONCE = 2**16
"""Vertices of parts that are placed together: each has a matrix of its own for a while."""
LEAST_QUATERNION = 1e-6  # its length; shorter ones have no direction
_FLIP_V = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])  # v to 1 − v
# Where in the 16 numbers of a matrix those are that are so many rows and columns on from each of its upper left 3×3.
_PLACES = {
    (rows, columns): np.array([(at // 3 + rows) % 3 * 4 + (at + columns) % 3 for at in range(9)])
    for rows in (1, 2)
    for columns in (1, 2)
}


def placed(part: MeshPart, matrices: Doubles, names: Sequence[str] = ()) -> MeshPart:
    """`part` once for each of `matrices` (instance, 4, 4), its fronts outside under those that mirror.

    names: of the objects that its instances are, where these are not all that of `part`.
    """
    count, vertices = len(matrices), len(part.positions)
    triangles = np.repeat(part.triangles[None], count, axis=0) + np.arange(count)[:, None, None] * vertices
    flipped = mirrored(matrices)
    if flipped.any():
        triangles[flipped] = triangles[flipped][:, :, ::-1]
    world = np.einsum("nij,vj->nvi", matrices[:, :3, :3], part.positions) + matrices[:, None, :3, 3]
    normals = part.normals
    if normals is not None:
        normals = np.einsum("nij,vj->nvi", _cofactors(matrices, flipped), normals).reshape(-1, 3)
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


def placed_each(parts: Sequence[MeshPart], matrices: Doubles) -> list[MeshPart]:
    """As `placed` does it, each of `parts` by the one of `matrices` (part, 4, 4) that is its own: many small ones at
    once, as each alone would take longer than its numbers.
    """
    flipped = mirrored(matrices)
    turned = _cofactors(matrices, flipped)
    found: list[MeshPart] = []
    first = 0
    for last in _runs([len(part.positions) for part in parts]):
        run = parts[first:last]
        own = np.repeat(np.arange(first, last), [len(part.positions) for part in run])
        world = np.einsum("vij,vj->vi", matrices[own, :3, :3], np.concatenate([part.positions for part in run]))
        world += matrices[own, :3, 3]
        rows = [part.positions if part.normals is None else part.normals for part in run]
        normals = np.einsum("vij,vj->vi", turned[own], np.concatenate(rows))
        start = 0
        for part, over in zip(run, flipped[first:last].tolist(), strict=True):
            end = start + len(part.positions)
            placed_part = replace(
                part,
                positions=world[start:end],
                triangles=part.triangles[:, ::-1] if over else part.triangles,
                normals=None if part.normals is None else normals[start:end],
            )
            found.append(placed_part)
            start = end
        first = last
    return found


def _runs(sizes: Sequence[int]) -> Iterator[int]:
    """Where runs of `sizes` end of which each is of one, or of several that are small together."""
    total = 0
    for number, size in enumerate(sizes):
        if total and total + size > AT_ONCE:
            yield number
            total = 0
        total += size
    if sizes:
        yield len(sizes)


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


def slot_transform(matrix: Doubles) -> tuple[float, float, float, float, float, float]:
    """That of a gpu.scene.types.TextureSlot, by a `matrix` (3, 3) that maps (u, v, 1) where v is from the bottom up."""
    a, b, c, d, e, f = (float(value) for value in (_FLIP_V @ matrix @ _FLIP_V)[:2].reshape(-1))
    return a, b, c, d, e, f


def cofactors(matrices: Doubles) -> Doubles:
    """What turns normals under `matrices` (matrix, 4, 4): inverse transpose times |determinant|, (matrix, 3, 3).

    Defined for singular matrices too.
    """
    return _cofactors(matrices, mirrored(matrices))


def mirrored(matrices: Doubles) -> Mask:
    """Which of the matrices (matrix, 4, 4) turn counter-clockwise into clockwise."""
    return np.asarray(np.linalg.det(matrices[:, :3, :3]) < 0.0)


def _cofactors(matrices: Doubles, flipped: Mask) -> Doubles:
    flat = matrices.reshape(-1, 16)  # several times as fast as np.cross of columns
    a, b, c, d = (flat.take(_PLACES[rows, columns], axis=1) for rows, columns in ((1, 1), (2, 2), (2, 1), (1, 2)))
    return (a * b - c * d).reshape(-1, 3, 3) * np.where(flipped, -1.0, 1.0)[:, None, None]


def _unit(vector: Doubles, otherwise: Doubles) -> Doubles:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-12 else otherwise

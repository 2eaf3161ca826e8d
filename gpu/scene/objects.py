"""The objects of a scene: all meshes of one name are one. Each has vertices of its own."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from gpu.errors import UserError, brief
from gpu.scene.geometry.soundness import sound
from gpu.scene.parts import MOST_ID
from gpu.scene.pauses import Pause, go_on
from gpu.scene.types import Doubles, Integers, Ints, Mask, Rgb, Scene


@dataclass(frozen=True)
class Move:
    """How an object is moved, in the world: made `scale` times as large about the middle of its box, turned about it by
    `rotation` about the axes X, Y and Z [°], of which Z comes first and Y, which is up, last; then moved by `offset`
    [m].
    """

    rotation: Rgb = (0.0, 0.0, 0.0)
    offset: Rgb = (0.0, 0.0, 0.0)
    scale: float = 1.0


def numbered(meshes: Iterable[tuple[tuple[str, ...], Integers]], used: Mask) -> tuple[tuple[str, ...], Ints]:
    """The ids of objects that have vertices, and the object of each vertex that is `used`.

    meshes: one behind the other, of each the names of its objects and which of them its vertices (vertex,) are of;
    used: of all their vertices, (vertex,).
    """
    known: dict[str, int] = {}

    @cache  # meshes of a file may share its names
    def numbers_of(names: tuple[str, ...]) -> Ints:
        ids = (brief(name, MOST_ID).strip() or "object" for name in names)
        return np.array([known.setdefault(one, len(known)) for one in ids], np.int32)

    numbers = np.concatenate([numbers_of(names)[own] for names, own in meshes])[used]
    there, own = np.unique(numbers, return_inverse=True)
    ids = [*known]
    return tuple(ids[number] for number in there), own.astype(np.int32)


def with_objects(scene: Scene, hidden: Collection[int], moves: Mapping[int, Move], pause: Pause = go_on) -> Scene:
    """`scene` without its `hidden` objects, by number, and with others moved; without triangles that lose their area.

    pause: called between steps that take long. Raises UserError where nothing is left.
    """
    scene = _moved(scene, moves, pause) if moves else scene
    shown, scaled = np.ones(len(scene.objects), bool), np.zeros(len(scene.objects), bool)
    shown[list(hidden)] = False
    scaled[[number for number, move in moves.items() if move.scale != 1.0]] = True
    if shown.all() and not scaled.any():
        return scene
    owner = scene.vertex_object[scene.triangles[:, 0]]
    kept, made = shown[owner], np.flatnonzero(scaled[owner])
    kept[made] &= sound(scene.vertices.astype(np.float64), scene.triangles[made])
    if not kept.any():
        raise UserError("objects: nothing that is visible has an area")
    if kept.all():
        return scene
    return replace(scene, triangles=scene.triangles[kept], triangle_material=scene.triangle_material[kept])


def _vertices_of(scene: Scene, wanted: Collection[int]) -> list[tuple[int, Ints]]:
    """Each of the `wanted` objects and its vertices, all found at once."""
    begins, numbers = scene.object_runs
    sizes, of = np.diff(begins, append=len(scene.vertex_object)), np.zeros(len(scene.objects), bool)
    of[[*wanted]] = True
    runs = np.flatnonzero(of[numbers])
    runs = runs[np.argsort(numbers[runs], kind="stable")]
    ends = np.cumsum(sizes[runs])
    own = np.arange(ends[-1]) + np.repeat(begins[runs] - ends + sizes[runs], sizes[runs])
    there, firsts = np.unique(numbers[runs], return_index=True)
    return [*zip(there.tolist(), np.split(own.astype(np.int32), ends[firsts[1:] - 1]), strict=True)]


def _moved(scene: Scene, moves: Mapping[int, Move], pause: Pause) -> Scene:
    vertices, normals = scene.vertices.copy(), scene.normals
    for number, own in _vertices_of(scene, moves):
        pause()
        move, positions = moves[number], scene.vertices[own].astype(np.float64)
        if any(move.rotation) or move.scale != 1.0:
            matrix, middle = rotation_matrix(move.rotation), (positions.min(axis=0) + positions.max(axis=0)) / 2.0
            positions = move.scale * (positions - middle) @ matrix.T + middle
        if any(move.rotation):
            normals = normals.copy() if normals is scene.normals else normals
            normals[own] = normals[own] @ matrix.T
        vertices[own] = positions + np.array(move.offset) * scene.placement.scale
    return replace(scene, vertices=vertices, normals=normals)


def rotation_matrix(degrees: Rgb) -> Doubles:
    """The matrix (3, 3) of rotations about the axes X, Y and Z, counter-clockwise as seen from an axis' end; Z comes
    first, Y last.
    """
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_y @ about_x @ about_z)

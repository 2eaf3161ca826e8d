"""The objects of a scene: all meshes of one name are one. Each has vertices of its own."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gpu.errors import brief
from gpu.scene.parts import MOST_ID
from gpu.scene.types import Doubles, Ints, Mask, Rgb, Scene


@dataclass(frozen=True)
class Move:
    """How an object is moved, in the world: turned about the middle of its box, by `rotation` about the axes X, Y and
    Z [°], of which Z comes first and Y, which is up, last; then moved by `offset` [m].
    """

    rotation: Rgb = (0.0, 0.0, 0.0)
    offset: Rgb = (0.0, 0.0, 0.0)


def numbered(names: Iterable[str], counts: Iterable[int], used: Mask) -> tuple[tuple[str, ...], Ints]:
    """The ids of objects that have vertices, and the object of each vertex that is `used`.

    names, counts: of meshes, one behind the other, and of their vertices; used: of these, (vertex,).
    """
    known: dict[str, int] = {}
    of_mesh = [known.setdefault(brief(name, MOST_ID).strip() or "object", len(known)) for name in names]
    numbers = np.repeat(np.array(of_mesh, np.int32), list(counts))[used]
    there, own = np.unique(numbers, return_inverse=True)
    ids = [*known]
    return tuple(ids[number] for number in there), own.astype(np.int32)


def object_boxes(scene: Scene) -> tuple[Doubles, Doubles]:
    """The low and the high corners (object, 3) of the boxes around a scene's objects, in world space."""
    low, high = np.full((len(scene.objects), 3), np.inf), np.full((len(scene.objects), 3), -np.inf)
    if scene.objects:
        # Meshes lie one behind the other, so that there are few runs of one object.
        starts = np.flatnonzero(np.diff(scene.vertex_object, prepend=-1))
        numbers = scene.vertex_object[starts]
        np.minimum.at(low, numbers, np.minimum.reduceat(scene.vertices, starts, axis=0))
        np.maximum.at(high, numbers, np.maximum.reduceat(scene.vertices, starts, axis=0))
    placement = scene.placement
    return low / placement.scale + placement.centre, high / placement.scale + placement.centre


def with_objects(scene: Scene, hidden: Iterable[int], moves: Mapping[int, Move]) -> Scene:
    """`scene` without its `hidden` objects, by number, and with others moved."""
    shown = np.ones(len(scene.objects), bool)
    shown[list(hidden)] = False
    kept = shown[scene.vertex_object[scene.triangles[:, 0]]]
    scene = _moved(scene, moves) if moves else scene
    if kept.all():
        return scene
    return replace(scene, triangles=scene.triangles[kept], triangle_material=scene.triangle_material[kept])


def _moved(scene: Scene, moves: Mapping[int, Move]) -> Scene:
    offsets = np.zeros((len(scene.objects), 3))
    offsets[list(moves)] = [move.offset for move in moves.values()]
    positions, normals = scene.vertices.astype(np.float64), scene.normals
    for number, move in moves.items():
        if any(move.rotation):
            own, matrix = scene.vertex_object == number, rotation_matrix(move.rotation)
            middle = (positions[own].min(axis=0) + positions[own].max(axis=0)) / 2.0
            positions[own] = (positions[own] - middle) @ matrix.T + middle
            normals = normals.copy() if normals is scene.normals else normals
            normals[own] = normals[own] @ matrix.T
    positions += (offsets * scene.placement.scale)[scene.vertex_object]
    return replace(scene, vertices=positions.astype(np.float32), normals=normals)


def rotation_matrix(degrees: Rgb) -> Doubles:
    """The matrix (3, 3) of rotations about the axes X, Y and Z, counter-clockwise as seen from an axis' end; Z comes
    first, Y last.
    """
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_y @ about_x @ about_z)

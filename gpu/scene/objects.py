"""The objects of a scene: all meshes of one name are one. Each has vertices of its own."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from gpu.errors import brief
from gpu.scene.parts import MOST_ID
from gpu.scene.types import Doubles, Ints, Mask, Rgb, Scene


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


def with_objects(scene: Scene, hidden: Iterable[int], offsets: Mapping[int, Rgb]) -> Scene:
    """`scene` without its `hidden` objects, by number, and with others moved by `offsets` [m]."""
    shown = np.ones(len(scene.objects), bool)
    shown[list(hidden)] = False
    kept = shown[scene.vertex_object[scene.triangles[:, 0]]]
    vertices = scene.vertices
    if offsets:
        moves = np.zeros((len(scene.objects), 3))
        moves[list(offsets)] = list(offsets.values())
        vertices = (vertices + (moves * scene.placement.scale)[scene.vertex_object]).astype(np.float32)
    if kept.all():
        return replace(scene, vertices=vertices)
    triangles, material = scene.triangles[kept], scene.triangle_material[kept]
    return replace(scene, vertices=vertices, triangles=triangles, triangle_material=material)

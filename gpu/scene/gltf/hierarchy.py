"""The nodes of a glTF scene with their world matrices."""

from dataclasses import dataclass

import numpy as np

from gpu.scene.gltf.document import Document
from gpu.scene.gltf.transforms import local_matrix
from gpu.scene.gltf.values import Value
from gpu.scene.types import Doubles


@dataclass(frozen=True, eq=False)
class PlacedNode:
    """A node and its matrix (4, 4) to world space."""

    entry: Value
    to_world: Doubles


def placed_nodes(document: Document) -> dict[str, PlacedNode]:
    """The nodes that the file's scene shows, by path, parents first.

    Raises SceneError for a node with two parents or one among its own descendants.
    """
    entries = document.root.objects("nodes")
    children = [[child.as_index(len(entries)) for child in entry.items("children")] for entry in entries]
    parents = [0] * len(entries)
    for number in (child for family in children for child in family):
        parents[number] += 1
        if parents[number] > 1:
            raise entries[number].error("is the child of two nodes; glTF allows one parent")
    roots = _roots(document, entries, parents)
    placed: dict[str, PlacedNode] = {}
    waiting = [(number, np.eye(4)) for number in reversed(roots)]
    while waiting:
        number, above = waiting.pop()
        to_world = above @ local_matrix(entries[number])
        if not np.isfinite(to_world).all():
            raise entries[number].error("its transform to the world is not finite")
        placed[entries[number].path] = PlacedNode(entries[number], to_world)
        waiting += [(child, to_world) for child in reversed(children[number])]
    return placed


def _roots(document: Document, entries: list[Value], parents: list[int]) -> list[int]:
    """Numbers of the nodes that the shown scene lists; a file without scenes shows all that have no parent."""
    root = document.root
    scenes = root.objects("scenes")
    if not scenes:
        return [number for number, count in enumerate(parents) if not count]
    scene = document.referred(root, "scene", "scenes") if root.has("scene") else scenes[0]
    if len(scenes) > 1:
        document.say(f"only one of {len(scenes)} scenes is shown: {scene.text('name', scene.path)}")
    roots = [item.as_index(len(entries)) for item in scene.items("nodes")]
    for number in roots:
        if parents[number] or roots.count(number) > 1:
            raise scene.error(f"node {number} is listed twice or is another node's child")
    return roots

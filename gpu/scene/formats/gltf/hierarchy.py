"""The nodes of a glTF scene with their world matrices."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from gpu.scene.animation.motion import STILL
from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.transforms import local_matrices
from gpu.scene.formats.gltf.values import Value
from gpu.scene.types import Doubles


@dataclass(frozen=True, eq=False)
class PlacedNode:
    """A node and its matrices (4, 4) to its parent and to world space.

    number: its place among the nodes that are shown; parent: that one's, or STILL; visible: neither it nor what it is
    in is hidden.
    """

    entry: Value
    number: int
    local: Doubles
    to_world: Doubles
    parent: int
    visible: bool


def placed_nodes(document: Document) -> dict[str, PlacedNode]:
    """The nodes that the file's scene shows, by path, parents first.

    Raises SceneError for a node with two parents or one among its own descendants, or without a usable transform.
    """
    entries = document.root.objects("nodes")
    children = [_numbers(document, entry, "children", len(entries)) for entry in entries]
    parents = [0] * len(entries)
    for number in (child for family in children for child in family):
        parents[number] += 1
        if parents[number] > 1:
            raise entries[number].error("is the child of two nodes; glTF allows one parent")
    roots = _roots(document, entries, parents)
    found: list[tuple[Value, int, bool]] = []
    waiting = [(number, STILL, True) for number in reversed(roots)]
    while waiting:
        number, parent, visible = waiting.pop()
        visible = visible and _visible(document, entries[number])
        waiting += [(child, len(found), visible) for child in reversed(children[number])]
        found.append((entries[number], parent, visible))
    shown = [entry for entry, _, _ in found]
    locals_ = local_matrices(shown)
    to_world = _to_world(shown, locals_, [parent for _, parent, _ in found])
    return {
        entry.path: PlacedNode(entry, number, locals_[number], to_world[number], parent, visible)
        for number, (entry, parent, visible) in enumerate(found)
    }


def _to_world(entries: list[Value], locals_: Doubles, parents: list[int]) -> Doubles:
    """Matrices (node, 4, 4) to world space of nodes, parents first, whose own are to their parents."""
    to_world, above = np.empty_like(locals_), np.eye(4)
    for number, parent in enumerate(parents):
        np.matmul(above if parent == STILL else to_world[parent], locals_[number], out=to_world[number])
    wrong = ~np.isfinite(to_world).all(axis=(1, 2))
    if wrong.any():
        raise entries[int(np.argmax(wrong))].error("its transform to the world is not finite")
    return to_world


def _visible(document: Document, entry: Value) -> bool:
    """Whether a node is shown (KHR_node_visibility); what is hidden is said."""
    extension = entry.extension("KHR_node_visibility")
    if extension is None or extension.choice("visible", {True: True, False: False}, True):
        return True
    document.ignored.add("is hidden, with what is in it, and was left out", entry.path)
    return False


def _roots(document: Document, entries: list[Value], parents: list[int]) -> list[int]:
    """Numbers of the nodes that the shown scene lists; a file without scenes shows all that have no parent."""
    root = document.root
    scenes = root.objects("scenes")
    if not scenes:
        return [number for number, count in enumerate(parents) if not count]
    scene = scenes[0]
    if root.has("scene"):
        scene = root.mended(lambda: document.referred(root, "scene", "scenes"), scene, "the first scene was used")
    if len(scenes) > 1:
        document.ignored.add(f"only one of {len(scenes)} scenes is shown: {scene.name(scene.path)}")
    roots = list(dict.fromkeys(_numbers(document, scene, "nodes", len(entries))))
    for number in roots:
        if parents[number]:
            raise scene.error(f"node {number} is listed but is another node's child; list the parent alone")
    return roots


def _numbers(document: Document, place: Value, key: str, count: int) -> list[int]:
    """The numbers of nodes that `place` lists at `key`, less those that there are not."""
    found = (document.attempt(partial(item.as_index, count), "the node") for item in place.parts(key))
    return [number for number in found if number is not None]

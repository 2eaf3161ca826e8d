"""Animations of a glTF file: translation, rotation, scale and morph weights of the nodes of its scene."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gpu.scene.gltf.accessors import read_finite
from gpu.scene.gltf.buffers import Buffers
from gpu.scene.gltf.hierarchy import PlacedNode
from gpu.scene.gltf.transforms import local_parts
from gpu.scene.gltf.values import Value
from gpu.scene.motion import STILL, Animation, Channel, Interpolation, Motion, Property
from gpu.scene.parts import unique_ids
from gpu.scene.types import Doubles

MOST_ANIMATIONS = 256  # that are offered
_COMPONENTS = {Property.TRANSLATION: 3, Property.ROTATION: 4, Property.SCALE: 3, Property.WEIGHTS: 1}
_LONGEST = 1e6  # seconds


@dataclass(frozen=True)
class Moved:
    """Numbers of nodes: of those that animations take elsewhere, with what is in them, and whose weights change."""

    nodes: frozenset[int]
    weights: frozenset[int]


NOT_MOVED = Moved(frozenset(), frozenset())


def read_animations(buffers: Buffers, placed: Mapping[str, PlacedNode]) -> tuple[Animation, ...]:
    """The file's animations of the `placed` nodes; what of them is broken or moves nothing is left out and said."""
    document = buffers.document
    entries = [entry for entry in document.root.parts("animations") if isinstance(entry.raw, dict)]
    found: list[tuple[str, tuple[Channel, ...]]] = []
    for entry in entries[:MOST_ANIMATIONS]:
        read = (partial(_channel, buffers, entry, channel, placed) for channel in entry.parts("channels"))
        channels = [document.attempt(one, "the channel") for one in read]
        usable = tuple(channel for channel in channels if channel is not None)
        if usable:
            found.append((entry.name(), usable))
        else:
            document.ignored.add("moves nothing that is shown and was left out", entry.path)
    more = f"animations beyond the first {MOST_ANIMATIONS} are not offered"
    document.ignored.add_count(more, len(entries[MOST_ANIMATIONS:]))
    ids = unique_ids((name for name, _ in found), "animation")
    return tuple(
        Animation(one, max(float(channel.times[-1]) for channel in channels), channels)
        for one, (_, channels) in zip(ids, found, strict=True)
    )


def moved_nodes(animations: Sequence[Animation], placed: Mapping[str, PlacedNode]) -> Moved:
    """What `animations` move of the `placed` nodes."""
    channels = [channel for animation in animations for channel in animation.channels]
    weights = frozenset(channel.node for channel in channels if channel.changes is Property.WEIGHTS)
    nodes = {channel.node for channel in channels if channel.changes is not Property.WEIGHTS}
    for node in placed.values():
        if node.parent in nodes:
            nodes.add(node.number)
    return Moved(frozenset(nodes), weights)


def motion_of(
    animations: tuple[Animation, ...], placed: Mapping[str, PlacedNode], lights: Iterable[int], cameras: Iterable[int]
) -> Motion | None:
    """`animations` and the nodes that they move, with the nodes of lights and of cameras; None without any."""
    if not animations:
        return None
    moved = moved_nodes(animations, placed).nodes
    rest = [np.zeros(10) if node.entry.has("matrix") else local_parts(node.entry) for node in placed.values()]
    parents = np.array([node.parent for node in placed.values()], np.int32)
    return Motion(
        parents,
        np.stack([node.local for node in placed.values()]),
        np.stack(rest),
        animations,
        lights=tuple(number if number in moved else STILL for number in lights),
        cameras=tuple(number if number in moved else STILL for number in cameras),
    )


def _channel(buffers: Buffers, animation: Value, entry: Value, placed: Mapping[str, PlacedNode]) -> Channel | None:
    """A channel; None where it says nothing that is shown. Raises SceneError where it is broken."""
    target = entry.object("target")
    path = target.text("path")
    if path == "pointer" or not target.has("node"):
        return None  # of an extension, which is said
    if path not in list(Property):
        raise target.get("path").error(f"must be one of {', '.join(Property)}, not {path!r:.40}")
    node = buffers.document.referred(target, "node", "nodes").path
    if node not in placed:
        return None
    changes = Property(path)
    if changes is not Property.WEIGHTS and placed[node].entry.has("matrix"):
        raise target.error("moves a node that has a matrix; export it with translation, rotation and scale")
    samplers = animation.items("samplers")
    sampler = samplers[entry.get("sampler").as_index(len(samplers))]
    kind = sampler.text("interpolation", "LINEAR")
    if kind not in list(Interpolation):
        raise sampler.get("interpolation").error(f"must be one of {', '.join(Interpolation)}, not {kind!r:.40}")
    times = read_finite(buffers, sampler, "input", (1,))[:, 0]
    if not len(times) or (np.diff(times) < 0.0).any() or times[0] < 0.0 or times[-1] > _LONGEST:
        raise sampler.error(f"its times must increase, from 0 to {_LONGEST:g} at the most")
    values = read_finite(buffers, sampler, "output", (_COMPONENTS[changes],))
    keys = _keys(sampler, values, len(times), changes, kind)
    return Channel(placed[node].number, changes, Interpolation(kind), times, keys)


def _keys(sampler: Value, values: Doubles, keys: int, changes: Property, kind: str) -> Doubles:
    """Values by key, (key, 1 or 3, component). Raises SceneError for another number of them than keys ask for."""
    parts = 3 if kind == Interpolation.CUBICSPLINE else 1
    components = values.size // (keys * parts) if changes is Property.WEIGHTS else _COMPONENTS[changes]
    if not values.size or values.size != keys * parts * components:
        raise sampler.error(f"{len(values)} values for {keys} keys")
    return values.reshape(keys, parts, components)

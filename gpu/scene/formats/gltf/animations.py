"""Animations of a glTF file: of the nodes of its scene, and by pointers of its materials and lights."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gpu.scene.animation.motion import (
    COMPONENTS,
    LIGHT_PROPERTIES,
    MATERIAL_PROPERTIES,
    NODE_PROPERTIES,
    STILL,
    Animation,
    Channel,
    Interpolation,
    Motion,
    Property,
)
from gpu.scene.formats.gltf.accessors import read_finite
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.hierarchy import PlacedNode
from gpu.scene.formats.gltf.pointers import Pointed, other_factor, pointed
from gpu.scene.formats.gltf.transforms import local_parts
from gpu.scene.formats.gltf.values import Value
from gpu.scene.parts import unique_ids
from gpu.scene.types import Doubles

MOST_ANIMATIONS = 256  # that are offered
# What a channel's own path can say; the others are pointed to.
_PATHS = [Property.TRANSLATION, Property.ROTATION, Property.SCALE, Property.WEIGHTS]
_LONGEST = 1e6  # seconds


@dataclass(frozen=True)
class Moved:
    """Numbers of nodes: of those that animations take elsewhere, with what is in them, and whose weights change."""

    nodes: frozenset[int]
    weights: frozenset[int]


NOT_MOVED = Moved(frozenset(), frozenset())


@dataclass(frozen=True)
class Movable:
    """What animations can move: nodes by path, parents first, and of each light of the scene the number in its file."""

    placed: Mapping[str, PlacedNode]
    lights: Sequence[int]

    def parts(self, of: Pointed) -> list[int]:
        """The numbers in the scene of what a pointer is of, none where it is not shown."""
        if of.of_light:
            return [index for index, number in enumerate(self.lights) if number == of.number]
        if of.changes in NODE_PROPERTIES:
            node = self.placed.get(f"{of.array}[{of.number}]")
            return [] if node is None else [node.number]
        return [of.number]


def read_animations(buffers: Buffers, movable: Movable) -> tuple[Animation, ...]:
    """The file's animations; what of them is broken or moves nothing that is shown is left out and said."""
    document = buffers.document
    entries = [entry for entry in document.root.parts("animations") if isinstance(entry.raw, dict)]
    found: list[tuple[str, tuple[Channel, ...]]] = []
    for entry in entries[:MOST_ANIMATIONS]:
        read = (partial(_channels, buffers, entry, channel, movable) for channel in entry.parts("channels"))
        channels = [document.attempt(one, "the channel") for one in read]
        usable = _complete(document, [channel for several in channels for channel in several or ()], movable)
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


def with_turned(animations: tuple[Animation, ...], turned: Mapping[int, Sequence[int]]) -> tuple[Animation, ...]:
    """`animations` of materials, which change those that tangents have turned from them as well, by number."""
    return tuple(
        replace(animation, channels=tuple(one for channel in animation.channels for one in _of_all(channel, turned)))
        for animation in animations
    )


def _of_all(channel: Channel, turned: Mapping[int, Sequence[int]]) -> list[Channel]:
    others = turned.get(channel.part, ()) if channel.changes in MATERIAL_PROPERTIES else ()
    return [channel, *(replace(channel, part=number) for number in others)]


def moved_nodes(animations: Sequence[Animation], placed: Mapping[str, PlacedNode]) -> Moved:
    """What `animations` move of the `placed` nodes."""
    channels = [channel for animation in animations for channel in animation.channels]
    weights = frozenset(channel.part for channel in channels if channel.changes is Property.WEIGHTS)
    nodes = {channel.part for channel in channels if channel.changes in NODE_PROPERTIES - {Property.WEIGHTS}}
    for node in placed.values():
        if node.parent in nodes:
            nodes.add(node.number)
    return Moved(frozenset(nodes), weights)


def motion_of(
    animations: tuple[Animation, ...], placed: Mapping[str, PlacedNode], lights: Iterable[int], cameras: Iterable[int]
) -> Motion | None:
    """`animations` and the nodes that they move, with the nodes of lights and of cameras; None without any."""
    if not (animations and placed):
        return None
    moved = moved_nodes(animations, placed).nodes
    rest = np.zeros((len(placed), 10))
    made = [node for node in placed.values() if not node.entry.has("matrix")]
    rest[[node.number for node in made]] = local_parts([node.entry for node in made])
    parents = np.array([node.parent for node in placed.values()], np.int32)
    return Motion(
        parents,
        np.stack([node.local for node in placed.values()]),
        rest,
        animations,
        lights=tuple(number if number in moved else STILL for number in lights),
        cameras=tuple(number if number in moved else STILL for number in cameras),
    )


def _channels(buffers: Buffers, animation: Value, entry: Value, movable: Movable) -> list[Channel]:
    """A channel for each part that it changes, none where nothing of that is shown. Raises SceneError where it is
    broken.
    """
    document, target = buffers.document, entry.object("target")
    path = target.text("path")
    if path == "pointer":
        of = pointed(document, target)
    elif not target.has("node"):
        return []  # of an extension, which is said
    elif path not in _PATHS:
        raise target.get("path").error(f"must be one of {', '.join(_PATHS)}, not {path!r:.40}")
    else:
        node = document.referred(target, "node", "nodes").path
        of = Pointed("nodes", int(node.removeprefix("nodes[").removesuffix("]")), Property(path))
    parts = movable.parts(of)
    if not parts:
        return []
    if of.changes in NODE_PROPERTIES:
        _check_node(target, movable.placed[f"nodes[{of.number}]"], of.changes)
    times, values, kind = _curve(buffers, animation, entry, of.changes)
    return [Channel(part, of.changes, kind, times, values) for part in parts]


def _complete(document: Document, channels: list[Channel], movable: Movable) -> tuple[Channel, ...]:
    """`channels`, and a constant one for each factor of a product and angle of a cone that another one needs."""
    there = {(channel.changes, channel.part) for channel in channels}
    needed: list[Channel] = []
    for channel in channels:
        number = movable.lights[channel.part] if channel.changes in LIGHT_PROPERTIES else channel.part
        other = other_factor(document, channel.changes, number)
        if other is not None and (other[0], channel.part) not in there:
            constant = np.array(other[1])[None, None]
            needed.append(Channel(channel.part, other[0], Interpolation.STEP, np.zeros(1), constant))
    return (*channels, *needed)


def _check_node(target: Value, node: PlacedNode, changes: Property) -> None:
    """Raise SceneError for what does not change of a node."""
    if changes is Property.VISIBLE and not node.visible:
        raise target.error("shows a node that its file hides, which stays hidden; let it be visible in the file")
    if changes in _PATHS[:3] and node.entry.has("matrix"):
        raise target.error("moves a node that has a matrix; export it with translation, rotation and scale")


def _curve(
    buffers: Buffers, animation: Value, entry: Value, changes: Property
) -> tuple[Doubles, Doubles, Interpolation]:
    """A channel's times (key,), values (key, 1 or 3, component) and what is between them. Raises SceneError."""
    sampler = animation.element("samplers", entry, "sampler")
    kind = sampler.text("interpolation", "LINEAR")
    if kind not in list(Interpolation):
        raise sampler.get("interpolation").error(f"must be one of {', '.join(Interpolation)}, not {kind!r:.40}")
    times = read_finite(buffers, sampler, "input", (1,))[:, 0]
    if not len(times) or (np.diff(times) < 0.0).any() or times[0] < 0.0 or times[-1] > _LONGEST:
        raise sampler.error(f"its times must increase, from 0 to {_LONGEST:g} at the most")
    values = read_finite(buffers, sampler, "output", (COMPONENTS[changes] or 1,))
    return times, _keys(sampler, values, len(times), changes, kind), Interpolation(kind)


def _keys(sampler: Value, values: Doubles, keys: int, changes: Property, kind: str) -> Doubles:
    """Values by key, (key, 1 or 3, component). Raises SceneError for another number of them than keys ask for."""
    parts = 3 if kind == Interpolation.CUBICSPLINE else 1
    components = COMPONENTS[changes] or values.size // (keys * parts)
    if not values.size or values.size != keys * parts * components:
        raise sampler.error(f"{len(values)} values for {keys} keys")
    return values.reshape(keys, parts, components)

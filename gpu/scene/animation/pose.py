"""Where nodes, and the meshes that hang on them, are at a time."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gpu.scene.animation.keyframes import value_at
from gpu.scene.animation.motion import STILL, Animation, Body, MorphTarget, Motion, Property, Skin
from gpu.scene.pauses import EVERY, Pause, go_on
from gpu.scene.scene_parts import MeshPart
from gpu.scene.transforms import AT_ONCE, cofactors, compose, placed, placed_each
from gpu.scene.types import Doubles, Ints

_PARTS = {Property.TRANSLATION: slice(0, 3), Property.ROTATION: slice(3, 7), Property.SCALE: slice(7, 10)}


@dataclass(frozen=True, eq=False)
class Pose:
    """Matrices (node, 4, 4) of nodes to the file's coordinates, the weights of those that are not as at rest, and those
    that are not visible.
    """

    to_world: Doubles
    weights: Mapping[int, Sequence[float]] = field(default_factory=dict)
    hidden: Collection[int] = ()


def pose_at(motion: Motion, animation: Animation, time: float, pause: Pause = go_on) -> Pose:
    """The pose at `time` [s] of an animation of `motion`."""
    rest, moved, weights, hidden = motion.rest.copy(), set[int](), dict[int, Sequence[float]](), set[int]()
    for number, channel in enumerate(animation.channels):
        if number % EVERY == 0:
            pause()
        value = value_at(channel, time)
        if channel.changes is Property.WEIGHTS:
            weights[channel.part] = value.tolist()
        elif channel.changes is Property.VISIBLE and value[0] < 0.5:
            hidden.add(channel.part)
        elif channel.changes in _PARTS:
            rest[channel.part, _PARTS[channel.changes]] = value
            moved.add(channel.part)
    local = motion.local.copy()
    nodes = sorted(moved)
    local[nodes] = compose(*(rest[nodes, part] for part in _PARTS.values()))
    to_world = np.empty_like(local)
    for node, parent in enumerate(motion.parents.tolist()):
        if node % EVERY == 0:
            pause()
        above = np.eye(4) if parent == STILL else to_world[parent]
        to_world[node] = above @ local[node]
        if parent in hidden:
            hidden.add(node)
    return Pose(to_world, weights, hidden)


def at_rest(motion: Motion, pause: Pause = go_on) -> Pose:
    """The pose without animation."""
    return pose_at(motion, Animation("", 0.0, ()), 0.0, pause)


def all_in_world(found: Sequence[tuple[MeshPart, Body]], pose: Pose) -> list[MeshPart]:
    """As `in_world` does it, each part with its body; those that are small and that nodes place are done together."""
    parts: dict[int, MeshPart] = {}
    together: dict[int, tuple[MeshPart, Doubles]] = {}
    for number, (part, body) in enumerate(found):
        if body.skin is None and len(body.instances) == 1 and len(part.positions) <= AT_ONCE:
            morphed = _morphed(part, body.targets, pose.weights.get(body.node, body.weights))
            together[number] = morphed, pose.to_world[body.node] @ body.instances[0]
        else:
            parts[number] = in_world(part, body, pose)
    if together:
        morphed_parts, matrices = zip(*together.values(), strict=True)
        parts |= zip(together, placed_each(morphed_parts, np.stack(matrices)), strict=True)
    return [parts[number] for number in range(len(found))]


def in_world(part: MeshPart, body: Body, pose: Pose) -> MeshPart:
    """`part`, whose geometry is that of `body`, in the file's coordinates in `pose`."""
    part = _morphed(part, body.targets, pose.weights.get(body.node, body.weights))
    if body.skin is None:
        return placed(part, pose.to_world[body.node] @ body.instances)
    matrices = _blended(_joint_matrices(body.skin, pose), body.joints, body.shares)
    world = np.einsum("vij,vj->vi", matrices[:, :3, :3], part.positions) + matrices[:, :3, 3]
    normals = part.normals
    if normals is not None:
        normals = np.einsum("vij,vj->vi", cofactors(matrices), normals)
    return replace(part, positions=world, normals=normals)


def _morphed(part: MeshPart, targets: Sequence[MorphTarget], weights: Sequence[float]) -> MeshPart:
    if not targets:
        return part
    positions, normals = part.positions, part.normals
    for target, weight in zip(targets, weights, strict=False):
        if weight != 0.0 and target.positions is not None:
            positions = positions + weight * target.positions
        if weight != 0.0 and target.normals is not None and normals is not None:
            normals = normals + weight * target.normals
    return replace(part, positions=positions, normals=normals)


def _joint_matrices(skin: Skin, pose: Pose) -> Doubles:
    """Matrices (joint, 4, 4) from bind pose to the file's coordinates (glTF 2.0, section 3.7.3.3)."""
    return np.asarray(pose.to_world[skin.joints] @ skin.inverse)


def _blended(matrices: Doubles, joints: Ints, shares: Doubles) -> Doubles:
    """The matrix (vertex, 4, 4) of each vertex: those of its joints by their shares, both (vertex, slot)."""
    return np.asarray(sum(shares[:, slot, None, None] * matrices[joints[:, slot]] for slot in range(shares.shape[1])))

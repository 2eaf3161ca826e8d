"""Skins of a glTF file, and what of them the vertices of a mesh follow."""

from collections.abc import Mapping

import numpy as np

from gpu.scene.animation.motion import Skin
from gpu.scene.formats.gltf.accessors import read_finite
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.hierarchy import PlacedNode
from gpu.scene.formats.gltf.primitives import Primitive
from gpu.scene.formats.gltf.values import Value
from gpu.scene.types import Doubles, Ints


def read_skin(buffers: Buffers, skin: Value, placed: Mapping[str, PlacedNode]) -> Skin:
    """The skin at `skin`, whose joints are `placed` nodes. Raises SceneError."""
    nodes = len(buffers.document.root.raw["nodes"])
    joints = [f"nodes[{item.as_index(nodes)}]" for item in skin.items("joints")]
    missing = [joint for joint in joints if joint not in placed]
    if missing or not joints:
        raise skin.error(f"its joint {missing[0]} is not in the scene" if missing else "has no joints")
    own = np.array([placed[joint].number for joint in joints], np.int32)
    if not skin.has("inverseBindMatrices"):
        return Skin(own, np.tile(np.eye(4), (len(joints), 1, 1)))
    inverse = read_finite(buffers, skin, "inverseBindMatrices", (16,))
    if len(inverse) < len(joints):
        raise skin.error(f"{len(inverse)} inverse bind matrices for {len(joints)} joints")
    return Skin(own, np.ascontiguousarray(inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)))


def bindings(primitive: Primitive, skin: Skin, place: Value) -> tuple[Ints, Doubles]:
    """The joints (vertex, slot) that each vertex follows, and their shares (vertex, slot). Raises SceneError."""
    attributes = primitive.attributes
    sets = [name[7:] for name in attributes if name.startswith("JOINTS_") and f"WEIGHTS_{name[7:]}" in attributes]
    if not sets:
        raise place.error("is skinned but has no JOINTS_0 and WEIGHTS_0")
    joints, weights = (
        np.concatenate([attributes[f"{name}_{number}"] for number in sets], axis=1) for name in ("JOINTS", "WEIGHTS")
    )
    numbers = np.where(weights > 0.0, joints, 0.0).astype(np.int32)
    if numbers.size and not 0 <= int(numbers.min()) <= int(numbers.max()) < len(skin.joints):
        raise place.error(f"its JOINTS name a joint that does not exist, there are {len(skin.joints)}")
    total = weights.sum(axis=1, keepdims=True)
    share = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), np.eye(1, weights.shape[1]))
    return numbers, share

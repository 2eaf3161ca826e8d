"""Skinned meshes in the pose that their joints have in the file."""

import numpy as np

from gpu.scene.gltf.accessors import read_finite
from gpu.scene.gltf.buffers import Buffers
from gpu.scene.gltf.hierarchy import PlacedNode
from gpu.scene.gltf.primitives import Primitive
from gpu.scene.gltf.values import Value
from gpu.scene.types import Doubles


def joint_matrices(buffers: Buffers, skin: Value, placed: dict[str, PlacedNode]) -> Doubles:
    """Matrices (joint, 4, 4) from bind pose to world space (glTF 2.0, section 3.7.3.3). Raises SceneError."""
    nodes = len(buffers.document.root.items("nodes"))
    joints = [f"nodes[{item.as_index(nodes)}]" for item in skin.items("joints")]
    missing = [joint for joint in joints if joint not in placed]
    if missing or not joints:
        raise skin.error(f"its joint {missing[0]} is not in the scene" if missing else "has no joints")
    to_world = np.stack([placed[joint].to_world for joint in joints])
    if not skin.has("inverseBindMatrices"):
        return to_world
    inverse = read_finite(buffers, skin, "inverseBindMatrices", (16,))
    if len(inverse) < len(joints):
        raise skin.error(f"{len(inverse)} inverse bind matrices for {len(joints)} joints")
    return np.asarray(to_world @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1))


def blend(primitive: Primitive, matrices: Doubles, place: Value) -> Doubles:
    """The matrix (vertex, 4, 4) of each vertex: those of its joints, weighted. Raises SceneError."""
    attributes = primitive.attributes
    sets = [name[7:] for name in attributes if name.startswith("JOINTS_") and f"WEIGHTS_{name[7:]}" in attributes]
    if not sets:
        raise place.error("is skinned but has no JOINTS_0 and WEIGHTS_0")
    joints, weights = (
        np.concatenate([attributes[f"{name}_{number}"] for number in sets], axis=1) for name in ("JOINTS", "WEIGHTS")
    )
    numbers = np.where(weights > 0.0, joints, 0.0).astype(np.int64)
    if numbers.size and not 0 <= int(numbers.min()) <= int(numbers.max()) < len(matrices):
        raise place.error(f"its JOINTS name a joint that does not exist, there are {len(matrices)}")
    total = weights.sum(axis=1, keepdims=True)
    share = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), np.eye(1, weights.shape[1]))
    return np.asarray(sum(share[:, slot, None, None] * matrices[numbers[:, slot]] for slot in range(share.shape[1])))

"""Skinned meshes in the pose that their joints have in the file."""

import numpy as np

from gpu.scene.gltf.accessors import read_floats
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
    inverse = read_floats(buffers, skin, "inverseBindMatrices", (16,))
    if len(inverse) < len(joints):
        raise skin.error(f"{len(inverse)} inverse bind matrices for {len(joints)} joints")
    return np.asarray(to_world @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1))


def blend(primitive: Primitive, matrices: Doubles, place: Value) -> Doubles:
    """The matrix (vertex, 4, 4) of each vertex: those of its joints, weighted. Raises SceneError."""
    joints, weights = (primitive.attributes.get(name) for name in ("JOINTS_0", "WEIGHTS_0"))
    if joints is None or weights is None:
        raise place.error("is skinned but has no JOINTS_0 and WEIGHTS_0")
    numbers = joints.astype(np.int64)
    if numbers.size and not 0 <= int(numbers.min()) <= int(numbers.max()) < len(matrices):
        raise place.error(f"JOINTS_0 names a joint that does not exist, there are {len(matrices)}")
    total = weights.sum(axis=1, keepdims=True)
    share = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), [[1.0, 0.0, 0.0, 0.0]])
    return np.asarray(sum(share[:, slot, None, None] * matrices[numbers[:, slot]] for slot in range(4)))

"""Binary trees over thin triangles, for tests of what is made of them."""

import numpy as np
import warp as wp

from gpu.device_scene.binary_tree import BinaryTree, binary_tree
from gpu.scene.types import Doubles

CPU = wp.get_device("cpu")


def rods(count: int, seed: int = 3) -> Doubles:
    """Thin triangles (triangle, corner, 3), of which some are as long as the room: what builders do badly."""
    rng = np.random.default_rng(seed)
    lengths = rng.choice([0.01, 0.05, 0.8], (count, 1, 1), p=[0.6, 0.3, 0.1])
    middles = rng.uniform(-0.5, 0.5, (count, 1, 3))
    return np.asarray(middles + lengths * rng.uniform(-0.5, 0.5, (count, 3, 3)), np.float32).astype(float)


def tree_over(triangles: Doubles) -> BinaryTree:
    """As Warp builds it, of leaves of up to two triangles."""
    vertices = wp.array(triangles.reshape(-1, 3), dtype=wp.vec3, device=CPU)
    indices = wp.array(np.arange(3 * len(triangles)), dtype=int, device=CPU)
    return binary_tree(wp.Mesh(vertices, indices, bvh_constructor="sah", bvh_leaf_size=2), len(triangles))

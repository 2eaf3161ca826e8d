"""Moving subtrees of a binary tree to where rays look at less."""

import numpy as np
import warp as wp
from binary_trees import CPU, rods, tree_over

from gpu.device_scene.binary_tree import NO_NODE, BinaryTree, ordered
from gpu.device_scene.bvh_reinsertion import reinsert


def surface(tree: BinaryTree) -> float:
    """That of all boxes but the leaves', over that of the root's."""
    nodes = ordered(tree).numpy()
    size = tree.upper.numpy() - tree.lower.numpy()
    areas = (size * np.roll(size, 1, axis=1)).sum(axis=1)
    return float(areas[nodes[tree.is_leaf.numpy()[nodes] == 0]].sum() / areas[tree.root])


def test_what_was_moved_is_a_tree_of_the_same_triangles_in_boxes_that_fit() -> None:
    triangles = rods(400)
    tree = tree_over(triangles)
    nodes = ordered(tree).numpy()
    leaves = {(tree.left.numpy()[node], tree.right.numpy()[node]) for node in nodes if tree.is_leaf.numpy()[node]}
    before = tree.parent.numpy().copy()
    reinsert(tree, ordered(tree))
    nodes = ordered(tree).numpy()
    assert (tree.parent.numpy() != before).any()
    left, right, is_leaf = (array.numpy() for array in (tree.left, tree.right, tree.is_leaf))
    assert {(left[node], right[node]) for node in nodes if is_leaf[node]} == leaves
    lower, upper = tree.lower.numpy(), tree.upper.numpy()
    inner = nodes[is_leaf[nodes] == 0]
    assert np.array_equal(lower[inner], np.minimum(lower[left[inner]], lower[right[inner]]))
    assert np.array_equal(upper[inner], np.maximum(upper[left[inner]], upper[right[inner]]))


def test_boxes_have_a_tenth_less_surface() -> None:
    tree = tree_over(rods(3000))
    before = surface(tree)
    reinsert(tree, ordered(tree))
    assert surface(tree) < 0.9 * before


def test_a_subtree_comes_to_where_it_is_nearest() -> None:
    """Of five leaves in a row one is on the wrong side of the tree."""
    tree, x = BinaryTree(), np.array([0.0, 0.1, 10.0, 10.1, 0.2])
    # 0 (1 (3: 0.0, 4: 0.1), 2 (5: 10.0, 6 (7: 10.1, 8: 0.2)))
    tree.root = 0
    tree.left = wp.array([1, 3, 5, 0, 1, 2, 7, 3, 4], dtype=int, device=CPU)
    tree.right = wp.array([2, 4, 6, 1, 2, 3, 8, 4, 5], dtype=int, device=CPU)
    tree.is_leaf = wp.array([0, 0, 0, 1, 1, 1, 0, 1, 1], dtype=int, device=CPU)
    members = [range(5), [0, 1], [2, 3, 4], [0], [1], [2], [3, 4], [3], [4]]
    corners = np.array([[x[list(of)].min(), x[list(of)].max()] for of in members])
    lower, upper = np.zeros((9, 3)), np.ones((9, 3))
    lower[:, 0], upper[:, 0] = corners[:, 0], corners[:, 1] + 0.01
    tree.lower, tree.upper = (wp.array(values, dtype=wp.vec3, device=CPU) for values in (lower, upper))
    tree.parent = wp.full(9, NO_NODE, dtype=int, device=CPU)
    reinsert(tree, ordered(tree))
    lengths = (tree.upper.numpy() - tree.lower.numpy())[:, 0][tree.is_leaf.numpy() == 0]
    assert np.allclose(sorted(lengths), [0.11, 0.11, 0.21, 10.11], atol=1e-5)

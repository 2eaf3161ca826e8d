"""Which nodes of a binary tree become those of one of four children."""

import numpy as np
from binary_trees import rods, tree_over

from gpu.device_scene.binary_tree import BinaryTree, ordered
from gpu.device_scene.bvh_collapse import MOST_TRIANGLES, TRIANGLE_COST, collapsed


def least_cost(tree: BinaryTree) -> float:
    """The least surface times looks of any tree of four children made of a binary one, by all ways to make it."""
    left, right, is_leaf = (array.numpy() for array in (tree.left, tree.right, tree.is_leaf))
    size = tree.upper.numpy() - tree.lower.numpy()
    areas = (size * np.roll(size, 1, axis=1)).sum(axis=1)

    def triangles(node: int) -> int:
        return int(right[node] - left[node]) if is_leaf[node] else triangles(left[node]) + triangles(right[node])

    def forests(node: int, number: int) -> list[list[int]]:
        """All ways to tell a subtree by up to so many nodes."""
        found = [[node]]
        if number > 1 and not is_leaf[node]:
            found += [
                [*a, *b]
                for own in range(1, number)
                for a in forests(left[node], own)
                for b in forests(right[node], number - own)
            ]
        return found

    known: dict[int, float] = {}

    def cost(node: int, *, opens: bool = False) -> float:
        if node not in known or opens:
            leaf = areas[node] * TRIANGLE_COST * triangles(node)
            if is_leaf[node]:
                return float(leaf)
            inner = areas[node] + min(sum(map(cost, way)) for way in forests(node, 4)[1:])
            known[node] = inner if opens or triangles(node) > MOST_TRIANGLES else min(leaf, inner)
        return float(known[node])

    return cost(tree.root, opens=True) / float(areas[tree.root])


def test_a_tree_costs_the_least_there_is() -> None:
    triangles = rods(120)
    tree = tree_over(triangles)
    wide, levels = collapsed(tree, ordered(tree), len(triangles))
    bounds = wide.bounds.numpy().reshape(-1, 3, 2, 4)
    size = bounds[:, :, 1] - bounds[:, :, 0]
    areas = (size * np.roll(size, 1, axis=1)).sum(axis=1)
    children, counts = wide.children.numpy().reshape(-1, 2, 4).transpose(1, 0, 2)
    whole = bounds[0][:, :, children[0] >= 0]
    root = whole[:, 1].max(axis=1) - whole[:, 0].min(axis=1)
    total = (root * np.roll(root, 1)).sum()
    inner = areas[(children >= 0) & (counts == 0)].sum() + total
    leaves = (areas * counts)[counts > 0].sum() * TRIANGLE_COST
    assert np.isclose((inner + leaves) / total, least_cost(tree), rtol=1e-4)
    assert counts.max() <= MOST_TRIANGLES
    assert len(children) == levels[-1]


def test_places_of_a_leaf_are_those_of_its_subtree() -> None:
    triangles = rods(300)
    tree = tree_over(triangles)
    wide, _ = collapsed(tree, ordered(tree), len(triangles))
    assert sorted(wide.places.numpy()) == list(range(300))

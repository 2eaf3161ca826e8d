"""Makes a binary tree a better one, by moving subtrees to where rays look at less for them.

A builder decides from the top down and never looks back: J. Bittner, M. Hapala, V. Havran, Fast Insertion-Based
Optimization of Bounding Volume Hierarchies, 2013. The search for the best place is that of D. Meister and J. Bittner,
Parallel Reinsertion for Bounding Volume Hierarchy Optimization, 2018. What is large is what rays meet most, so a few
thousand of the largest boxes give nearly all that there is.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.device import launch_on_host
from gpu.core.kernel_loading import host_kernel
from gpu.core.parameters import parameters
from gpu.device_scene.binary_tree import NO_NODE, BinaryTree, area_of, half_area
from gpu.scene.types import Doubles, Ints


@wp.struct
@dataclass
class ReinsertionParameters:
    """moved: of a round, nodes with the largest boxes; rounds: how often each has a chance to move."""

    moved: int = 4096
    rounds: int = 3


REINSERTION_PARAMETERS: ReinsertionParameters = parameters(ReinsertionParameters)


@wp.func
def area_with(tree: BinaryTree, node: int, other: int) -> float:
    """Half the surface of the box around those of two nodes."""
    return half_area(wp.min(tree.lower[node], tree.lower[other]), wp.max(tree.upper[node], tree.upper[other]))


@wp.func
def sibling_of(tree: BinaryTree, node: int) -> int:
    """The other child of a node's parent."""
    above = tree.parent[node]
    return wp.where(tree.left[above] == node, tree.right[above], tree.left[above])


@wp.struct
class Place:
    """A node beside which another one would save so much surface of boxes."""

    node: int
    saved: float


@wp.func
def best_below(tree: BinaryTree, moved: int, top: int, saved: float, best: Place) -> Place:
    """The best place for a node below another one or beside it, if there is a better one than `best`.

    saved: the surface that is saved by the time that the search has come down to `top`.
    """
    own = area_of(tree, moved)
    node = int(top)
    left = float(saved)
    done = bool(False)
    while not done:
        around = area_with(tree, node, moved)
        if left - around > best.saved:
            best.saved = left - around
            best.node = node
        below = left - (around - area_of(tree, node))
        if tree.is_leaf[node] == 0 and below - own > best.saved:
            left = below
            node = tree.left[node]
        else:
            # Up until there is something on the right that was not looked at.
            climbing = bool(True)
            while climbing:
                if node == top:
                    climbing = False
                    done = True
                elif tree.left[tree.parent[node]] == node:
                    node = tree.right[tree.parent[node]]
                    climbing = False
                else:
                    node = tree.parent[node]
                    left += area_with(tree, node, moved) - area_of(tree, node)
    return best


@wp.func
def best_place(tree: BinaryTree, moved: int) -> Place:
    """Where a node, which is neither the root nor a child of that, saves most surface; NO_NODE where it is."""
    best = Place()
    best.node = NO_NODE
    best.saved = 0.0
    above = tree.parent[moved]
    beside = sibling_of(tree, moved)
    # Without the node its parent would not be there, and boxes above would be smaller.
    saved = area_of(tree, above)
    lower = tree.lower[beside]
    upper = tree.upper[beside]
    if tree.is_leaf[beside] == 0:
        below = saved - (area_with(tree, beside, moved) - area_of(tree, beside))
        best = best_below(tree, moved, tree.left[beside], below, best)
        best = best_below(tree, moved, tree.right[beside], below, best)
    while above != tree.root:
        other = sibling_of(tree, above)
        best = best_below(tree, moved, other, saved, best)
        above = tree.parent[above]
        lower = wp.min(lower, tree.lower[other])
        upper = wp.max(upper, tree.upper[other])
        saved += area_of(tree, above) - half_area(lower, upper)
    return best


@wp.func
def replace_child(tree: BinaryTree, node: int, child: int, other: int) -> None:
    """Have `other` in the place of a `child` of a node."""
    if tree.left[node] == child:
        tree.left[node] = other
    else:
        tree.right[node] = other
    tree.parent[other] = node


@wp.func
def fit_up(tree: BinaryTree, start: int) -> None:
    """Fit the boxes from a node up to the root to those of their children."""
    node = int(start)
    while node != NO_NODE:
        left = tree.left[node]
        right = tree.right[node]
        tree.lower[node] = wp.min(tree.lower[left], tree.lower[right])
        tree.upper[node] = wp.max(tree.upper[left], tree.upper[right])
        node = tree.parent[node]


@host_kernel
def reinsert_kernel(tree: BinaryTree, moved: wp.array[int]) -> None:
    """Move each node of a list, moved (place,), to where it is best, one after the other."""
    for index in range(moved.shape[0]):
        node = moved[index]
        above = tree.parent[node]
        if above != NO_NODE and above != tree.root:
            place = best_place(tree, node)
            if place.node != NO_NODE:
                # The parent goes along, and comes between the place and what was above that.
                beside = sibling_of(tree, node)
                over = tree.parent[above]
                replace_child(tree, over, above, beside)
                fit_up(tree, over)
                replace_child(tree, tree.parent[place.node], place.node, above)
                tree.left[above] = place.node
                tree.right[above] = node
                tree.parent[place.node] = above
                fit_up(tree, above)


def _areas_of(tree: BinaryTree, nodes: Ints) -> Doubles:
    """Half the surface of nodes' boxes (node,)."""
    size = tree.upper.numpy()[nodes] - tree.lower.numpy()[nodes]
    return np.asarray(size[:, 0] * size[:, 1] + size[:, 1] * size[:, 2] + size[:, 2] * size[:, 0])


def reinsert(tree: BinaryTree, order: wp.array) -> None:
    """Move subtrees to where rays look at less for them; order: as of `ordered`, which the tree then has no more."""
    nodes, most = order.numpy(), REINSERTION_PARAMETERS.moved
    areas = _areas_of(tree, nodes)
    largest = nodes[np.argpartition(-areas, min(most, len(areas) - 1))[:most]]
    for _ in range(REINSERTION_PARAMETERS.rounds):
        moved = largest[np.argsort(-_areas_of(tree, largest), kind="stable")]
        launch_on_host(reinsert_kernel, [tree, wp.array(moved, dtype=int, device=order.device)])

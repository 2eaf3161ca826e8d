"""The binary tree that Warp builds for a mesh, on the host, and how to make it a better one.

A builder decides from the top down and never looks back. Subtrees that would cost rays less elsewhere are moved there:
J. Bittner, M. Hapala, V. Havran, Fast Insertion-Based Optimization of Bounding Volume Hierarchies, 2013. The search for
the best place is that of D. Meister and J. Bittner, Parallel Reinsertion for Bounding Volume Hierarchy Optimization,
2018. What is large is what rays meet most, so a few thousand of the largest boxes give nearly all that there is.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.device import launch, launch_on_host
from gpu.core.kernel_loading import host_kernel
from gpu.core.parameters import parameters
from gpu.scene.types import Doubles, Ints

NO_NODE = wp.constant(-1)


@wp.struct
class BinaryTree:
    """Nodes of a binary tree, in arrays of the CPU.

    lower, upper (node,): their boxes; left, right (node,): their children or, where `is_leaf` is 1, the first place of
    their triangles and the one after the last; parent (node,): NO_NODE for the root.
    """

    root: int
    lower: wp.array[wp.vec3]
    upper: wp.array[wp.vec3]
    left: wp.array[int]
    right: wp.array[int]
    is_leaf: wp.array[int]
    parent: wp.array[int]


@wp.struct
@dataclass
class ReinsertionParameters:
    """moved: of a round, nodes with the largest boxes; rounds: how often each has a chance to move."""

    moved: int = 4096
    rounds: int = 3


REINSERTION_PARAMETERS: ReinsertionParameters = parameters(ReinsertionParameters)


@wp.func_native("return *wp::mesh_get(mesh).bvh.root;")
def root_of(mesh: wp.uint64) -> wp.int32:
    """The root of a mesh's binary tree."""


@wp.func_native("return wp::mesh_get(mesh).bvh.num_nodes;")
def node_count_of(mesh: wp.uint64) -> wp.int32:
    """How many nodes a mesh's binary tree has, of which some may be of no use."""


@wp.func_native("""
    const wp::BVH& tree = wp::mesh_get(mesh).bvh;
    return wp::vec_t<3, wp::int32>(tree.node_lowers[node].b, tree.node_lowers[node].i, tree.node_uppers[node].i);
""")
def entry_of(mesh: wp.uint64, node: int) -> wp.vec3i:
    """A node of a mesh's binary tree: (0, left, right) or, for a leaf, (1, first place, place after the last)."""


@wp.func_native("""
    const wp::BVHPackedNodeHalf corner = wp::mesh_get(mesh).bvh.node_lowers[node];
    return wp::vec3(corner.x, corner.y, corner.z);
""")
def lower_of(mesh: wp.uint64, node: int) -> wp.vec3:
    """The least corner of a node's box."""


@wp.func_native("""
    const wp::BVHPackedNodeHalf corner = wp::mesh_get(mesh).bvh.node_uppers[node];
    return wp::vec3(corner.x, corner.y, corner.z);
""")
def upper_of(mesh: wp.uint64, node: int) -> wp.vec3:
    """The greatest corner of a node's box."""


@wp.kernel
def read_nodes_kernel(first: int, mesh: wp.uint64, root: wp.array[int], lower: wp.array[wp.vec3],
                      upper: wp.array[wp.vec3], entries: wp.array[wp.vec3i]) -> None:  # fmt: skip
    """One thread a node that a mesh's tree may have: its box and `entry_of`; root (1,)."""
    node = first + wp.tid()
    if node == 0:
        root[0] = root_of(mesh)
    if node < node_count_of(mesh):
        lower[node] = lower_of(mesh, node)
        upper[node] = upper_of(mesh, node)
        entries[node] = entry_of(mesh, node)


@host_kernel
def name_parents_kernel(tree: BinaryTree, order: wp.array[int]) -> None:
    """Each node's parent, and the nodes in use so that each comes after its parent.

    order (node,): NO_NODE after the last one.
    """
    tree.parent[tree.root] = NO_NODE
    order[0] = tree.root
    count = int(1)
    place = int(0)
    while place < count:
        node = order[place]
        if tree.is_leaf[node] == 0:
            for side in range(2):
                child = wp.where(side == 0, tree.left[node], tree.right[node])
                tree.parent[child] = node
                order[count] = child
                count += 1
        place += 1


@wp.func
def half_area(lower: wp.vec3, upper: wp.vec3) -> float:
    """Half the surface of a box."""
    size = upper - lower
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0]


@wp.func
def area_of(tree: BinaryTree, node: int) -> float:
    """Half the surface of a node's box."""
    return half_area(tree.lower[node], tree.upper[node])


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
    """Move each node of a list to where it is best, one after the other."""
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


def binary_tree(mesh: wp.Mesh, triangles: int) -> BinaryTree:
    """The tree of a mesh of so many triangles, in arrays of the CPU."""
    device, nodes = mesh.device, 2 * triangles - 1
    lower, upper = (wp.zeros(nodes, dtype=wp.vec3, device=device) for _ in range(2))
    entries, root = wp.zeros(nodes, dtype=wp.vec3i, device=device), wp.zeros(1, dtype=int, device=device)
    launch(read_nodes_kernel, nodes, [mesh.id, root, lower, upper, entries], device)
    tree, host = BinaryTree(), wp.get_device("cpu")
    tree.root = int(root.numpy()[0])
    tree.lower, tree.upper = lower.to(host), upper.to(host)
    columns = entries.numpy().T
    tree.is_leaf, tree.left, tree.right = (wp.array(column, dtype=int, device=host) for column in columns)
    tree.parent = wp.full(nodes, NO_NODE, dtype=int, device=host)
    return tree


def ordered(tree: BinaryTree) -> wp.array:
    """The nodes of a tree, each after its parent, which each is told."""
    order = wp.full(len(tree.parent), NO_NODE, dtype=int, device=tree.parent.device)
    launch_on_host(name_parents_kernel, [tree, order])
    return order[: int((order.numpy() != NO_NODE).sum())]


def areas_of(tree: BinaryTree, nodes: Ints | slice) -> Doubles:
    """Half the surface of nodes' boxes (node,)."""
    size = tree.upper.numpy()[nodes] - tree.lower.numpy()[nodes]
    return np.asarray(size[:, 0] * size[:, 1] + size[:, 1] * size[:, 2] + size[:, 2] * size[:, 0])


def reinsert(tree: BinaryTree, order: wp.array, chosen: ReinsertionParameters = REINSERTION_PARAMETERS) -> None:
    """Move subtrees to where rays look at less for them; order: as of `ordered`, which the tree then has no more."""
    nodes = order.numpy()
    areas = areas_of(tree, nodes)
    largest = nodes[np.argpartition(-areas, min(chosen.moved, len(areas) - 1))[: chosen.moved]]
    for _ in range(chosen.rounds):
        moved = largest[np.argsort(-areas_of(tree, largest), kind="stable")]
        launch_on_host(reinsert_kernel, [tree, wp.array(moved, dtype=int, device=order.device)])

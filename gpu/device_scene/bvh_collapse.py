"""Which nodes of a binary tree become those of a tree of four children a node, so that rays look at least.

By dynamic programming from the leaves up, what a subtree costs as one node or as up to four children of another: H.
Ylitie, T. Karras, S. Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017, § 4.1.
"""

import numpy as np
import warp as wp

from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch_on_host
from gpu.core.kernel_loading import host_kernel
from gpu.device_scene.binary_tree import NO_NODE, BinaryTree, area_of
from gpu.scene.types import Ints

WIDTH = 4
# Of a leaf: more are not told apart, fewer make more nodes.
MOST_TRIANGLES = wp.constant(4)
# What looking at a triangle takes of what a node takes.
TRIANGLE_COST = wp.constant(0.6)


@wp.struct
class Collapse:
    """By how many children subtrees are told.

    order (place,): nodes, each after its parent; triangles (node,): of its subtree; costs (node, 4): of a subtree told
    by up to 1, 2, 3 or 4 nodes, surface times looks; left (node, 4): how many of these the left child has, 0 where
    one fewer is as good and, of a subtree told by one, where that is a leaf.
    """

    order: wp.array[int]
    triangles: wp.array[int]
    costs: wp.array2d[float]
    left: wp.array2d[int]


@wp.struct
class WideTree:
    """queue (node,): the node of the binary tree that each stands for; first (binary node,): the place of the first
    triangle of its subtree; places (place,): which of the binary tree's places each is; levels (level,): their first
    nodes; counts (2,): nodes and levels; bounds, children: of gpu.device_scene.bvh.Bvh.
    """

    queue: wp.array[int]
    first: wp.array[int]
    places: wp.array[int]
    levels: wp.array[int]
    counts: wp.array[int]
    bounds: wp.array[wp.vec4]
    children: wp.array[wp.vec4i]


@host_kernel
def collapse_kernel(tree: BinaryTree, of: Collapse) -> None:
    """From the leaves up, costs and what comes to the left."""
    for place in range(of.order.shape[0]):
        node = of.order[of.order.shape[0] - 1 - place]
        area = area_of(tree, node)
        left = tree.left[node]
        right = tree.right[node]
        if tree.is_leaf[node] == 1:
            of.triangles[node] = right - left
            for number in range(4):
                of.costs[node, number] = area * TRIANGLE_COST * float(right - left)
                of.left[node, number] = 0
        else:
            total = of.triangles[left] + of.triangles[right]
            of.triangles[node] = total
            for number in range(1, 4):
                best = float(wp.inf)
                share = int(0)
                for own in range(number):
                    cost = of.costs[left, own] + of.costs[right, number - 1 - own]
                    if cost < best:
                        best = cost
                        share = own + 1
                of.costs[node, number] = best
                of.left[node, number] = share
            of.costs[node, 0] = area + of.costs[node, 3]
            of.left[node, 0] = of.left[node, 3]
            whole = area * TRIANGLE_COST * float(total)
            if total <= MOST_TRIANGLES and whole <= of.costs[node, 0]:
                of.costs[node, 0] = whole
                of.left[node, 0] = 0
            for number in range(1, 4):
                if of.costs[node, number - 1] <= of.costs[node, number]:
                    of.costs[node, number] = of.costs[node, number - 1]
                    of.left[node, number] = 0


@host_kernel
def wide_nodes_kernel(tree: BinaryTree, of: Collapse, wide: WideTree) -> None:
    """The wide tree's nodes, level by level."""
    # Triangles of a subtree lie together.
    wide.first[tree.root] = 0
    for index in range(of.order.shape[0]):
        node = of.order[index]
        start = wide.first[node]
        if tree.is_leaf[node] == 1:
            for one in range(tree.left[node], tree.right[node]):
                wide.places[start + one - tree.left[node]] = one
        else:
            wide.first[tree.left[node]] = start
            wide.first[tree.right[node]] = start + of.triangles[tree.left[node]]
    wide.queue[0] = tree.root
    count = int(1)
    level = int(0)
    end = int(1)
    place = int(0)
    while place < count:
        if place == 0 or place == end:
            wide.levels[level] = place
            level += 1
            end = count
        children = wp.vec4i(wide.queue[place], NO_NODE, NO_NODE, NO_NODE)
        budgets = wp.vec4i(4, 0, 0, 0)
        number = int(1)
        slot = int(0)
        while slot < number:
            node = children[slot]
            budget = budgets[slot]
            share = int(0)
            opens = budget > 1
            if slot == 0 and number == 1 and node == wide.queue[place]:
                share = of.left[node, 0]
                opens = share > 0
            elif opens:
                share = of.left[node, budget - 1]
            if opens and share > 0:
                children[slot] = tree.left[node]
                budgets[slot] = share
                children[number] = tree.right[node]
                budgets[number] = budget - share
                number += 1
            elif opens:
                budgets[slot] = budget - 1
            else:
                slot += 1
        for index in range(4):
            child = children[index]
            lower = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
            upper = lower
            target = int(NO_NODE)
            triangles = int(0)
            if child != NO_NODE:
                lower = tree.lower[child]
                upper = tree.upper[child]
                if tree.is_leaf[child] == 1 or of.left[child, 0] == 0:
                    target = wide.first[child]
                    triangles = of.triangles[child]
                else:
                    target = count
                    wide.queue[count] = child
                    count += 1
            for axis in range(3):
                wide.bounds[6 * place + 2 * axis][index] = lower[axis]
                wide.bounds[6 * place + 2 * axis + 1][index] = upper[axis]
            wide.children[2 * place][index] = target
            wide.children[2 * place + 1][index] = triangles
        place += 1
    wide.levels[level] = count
    wide.counts[0] = count
    wide.counts[1] = level


def collapsed(tree: BinaryTree, order: wp.array, triangles: int) -> tuple[WideTree, Ints]:
    """The tree of four children a node of a binary one, in arrays of the CPU, and the first node of each level, and
    after the last one how many there are.

    order (node,): the binary tree's, each after its parent.
    """
    nodes, host = len(tree.parent), order.device
    of, wide = Collapse(), WideTree()
    of.order, of.triangles = order, wp.zeros(nodes, dtype=int, device=host)
    of.costs, of.left = (wp.zeros((nodes, WIDTH), dtype=kind, device=host) for kind in (float, int))
    launch_on_host(collapse_kernel, [tree, of])
    most = max(len(order) // 2, 1)
    wide.queue, wide.levels = (wp.zeros(most + 1, dtype=int, device=host) for _ in range(2))
    wide.first, wide.places = wp.zeros(nodes, dtype=int, device=host), wp.zeros(triangles, dtype=int, device=host)
    wide.counts = wp.zeros(2, dtype=int, device=host)
    wide.bounds = wp.empty(6 * most, dtype=wp.vec4, device=host)
    wide.children = wp.empty(2 * most, dtype=wp.vec4i, device=host)
    launch_on_host(wide_nodes_kernel, [tree, of, wide])
    count, levels = wide.counts.numpy()
    wide.bounds, wide.children = wide.bounds[: 6 * count], wide.children[: 2 * count]
    return wide, np.asarray(wide.levels.numpy()[: levels + 1])

"""A hierarchy over the photons of a frame, and the photons nearest to a surface point found in it.

A balanced tree over photons in Morton order (gpu.core.range_tree) takes the place of the 2009 paper's kd-tree: it needs
no splits, so it is made in a few short launches, and its levels have as many nodes as those of a kd-tree that halves.
"""

from functools import cache
from typing import Any

import warp as wp

from gpu.clustering.grid import ClusteringParameters, separation
from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import allocate, launch
from gpu.core.range_tree import NodeStack, levels_of, run_begin
from gpu.lights.photon_map import Photons

# Photons of a leaf at most: fewer are more boxes to test, more are more photons.
PER_LEAF = 4


@wp.struct
class PhotonTree:
    """The hierarchy over the photons of one map.

    levels: below the root; leaves: the number of the first one. lower, upper (node,): box of a node's photons, turned
    inside out where it has none; flow (node,): sum of flux times normal, by brightness [W].
    """

    photons: Photons
    levels: int
    leaves: int
    lower: wp.array[wp.vec3]
    upper: wp.array[wp.vec3]
    flow: wp.array[wp.vec3]


def allocate_tree(photons: Photons) -> PhotonTree:
    """A tree for all photons that there may be."""
    levels = levels_of(len(photons.flux), PER_LEAF)
    tree: PhotonTree = allocate(PhotonTree, 2 << levels, photons.flux.device)
    tree.photons, tree.levels, tree.leaves = photons, levels, 1 << levels
    return tree


@wp.kernel
def photon_leaf_kernel(first: int, tree: PhotonTree) -> None:
    """One thread a leaf: what it holds."""
    number = first + wp.tid()
    count = tree.photons.count[0]
    lower = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
    upper = -lower
    flow = wp.vec3(0.0, 0.0, 0.0)
    for photon in range(run_begin(count, tree.levels, number), run_begin(count, tree.levels, number + 1)):
        lower = wp.min(lower, tree.photons.position[photon])
        upper = wp.max(upper, tree.photons.position[photon])
        flow += tree.photons.normal[photon] * brightness(tree.photons.flux[photon])
    tree.lower[tree.leaves + number] = lower
    tree.upper[tree.leaves + number] = upper
    tree.flow[tree.leaves + number] = flow


@wp.kernel
def photon_node_kernel(first: int, begin: int, tree: PhotonTree) -> None:
    """One thread a node of the level that begins with node `begin`: what both children hold."""
    node = begin + first + wp.tid()
    tree.lower[node] = wp.min(tree.lower[2 * node], tree.lower[2 * node + 1])
    tree.upper[node] = wp.max(tree.upper[2 * node], tree.upper[2 * node + 1])
    tree.flow[node] = tree.flow[2 * node] + tree.flow[2 * node + 1]


def build_tree(tree: PhotonTree) -> None:
    """Fill in the nodes for the photons that there are now."""
    device = tree.lower.device
    launch(photon_leaf_kernel, tree.leaves, [tree], device)
    for level in reversed(range(tree.levels)):
        launch(photon_node_kernel, 1 << level, [1 << level, tree], device)


@wp.func
def box_distance(lower: wp.vec3, upper: wp.vec3, position: wp.vec3) -> float:
    """How far `position` is from a box; 0 within it."""
    return wp.length(wp.max(wp.max(lower - position, position - upper), wp.vec3(0.0, 0.0, 0.0)))


@cache
def photon_search(number: int) -> wp.Function:
    """The function that finds the `number` photons nearest to a surface point, on its side.

    search(tree, alike, position, normal, reach, own) has `distance` and `photon`, vectors of `number` elements, nearest
    first; −1 where there are no more within `reach`. own: a photon that does not count, or −1. Distances are stretched
    along the normals, and those of photons with unlike normals are not looked at (`alike`): what arrives on the other
    side of a wall or on the wall beside tells nothing, nor does it widen the estimate.
    """
    distances: Any = wp.types.vector(length=number, dtype=float)
    indices: Any = wp.types.vector(length=number, dtype=int)

    @wp.struct
    class NearestPhotons:
        distance: distances
        photon: indices

    @wp.func
    def search(tree: PhotonTree, alike: ClusteringParameters, position: wp.vec3, normal: wp.vec3, reach: float,
               own: int) -> NearestPhotons:  # fmt: skip
        found = NearestPhotons()
        for f in range(wp.static(number)):
            found.distance[f] = reach
            found.photon[f] = -1
        stack = NodeStack()
        stack[0] = 1
        top = int(1)
        count = tree.photons.count[0]
        while top > 0:
            top -= 1
            node = stack[top]
            if box_distance(tree.lower[node], tree.upper[node], position) >= found.distance[wp.static(number - 1)]:
                continue
            if node < tree.leaves:
                left = box_distance(tree.lower[2 * node], tree.upper[2 * node], position)
                right = box_distance(tree.lower[2 * node + 1], tree.upper[2 * node + 1], position)
                nearer = wp.where(left <= right, 2 * node, 2 * node + 1)
                stack[top] = 4 * node + 1 - nearer
                stack[top + 1] = nearer
                top += 2
                continue
            leaf = node - tree.leaves
            for photon in range(run_begin(count, tree.levels, leaf), run_begin(count, tree.levels, leaf + 1)):
                photon_normal = tree.photons.normal[photon]
                if photon != own and wp.dot(photon_normal, normal) > alike.normal_threshold:
                    index = photon
                    distance = separation(alike, position, normal, tree.photons.position[photon], photon_normal)
                    if distance < found.distance[wp.static(number - 1)]:
                        for f in range(wp.static(number)):
                            if distance < found.distance[f]:
                                held_distance = found.distance[f]
                                held_photon = found.photon[f]
                                found.distance[f] = distance
                                found.photon[f] = index
                                distance = held_distance
                                index = held_photon
        return found

    return search

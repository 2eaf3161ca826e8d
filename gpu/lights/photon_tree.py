"""A hierarchy over the photons of a frame, and the photons nearest to one of them found in it.

A balanced tree over photons in Morton order (gpu.core.range_tree) takes the place of the 2009 paper's kd-tree: it needs
no splits, so it is made in a few short launches, and its levels have as many nodes as those of a kd-tree that halves.
"""

from functools import cache
from math import cos, radians, sin
from typing import Any

import warp as wp

from gpu.clustering.grid import ClusteringParameters, separation
from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import bit_count, float_least, place_of_least
from gpu.core.range_tree import MOST_LEVELS, levels_of, run_begin, run_holding
from gpu.lights.photon_map import Photons

# Photons of a leaf, about: fewer are more boxes to test, more are more photons.
PER_LEAF = 4
# Nodes that a search looks at together, and how far below the one above them.
TOGETHER = wp.constant(8)
LEVELS_A_STEP = wp.constant(3)
NodeDistances: Any = wp.types.vector(length=int(TOGETHER) * (MOST_LEVELS // int(LEVELS_A_STEP) + 1), dtype=float)
# A normal's component is that of a diagonal direction from sin 22.5° on; so all are within 33° of theirs.
DIAGONAL = wp.constant(0.3826834)
COS_NEAR, SIN_NEAR = wp.constant(cos(radians(33.0))), wp.constant(sin(radians(33.0)))


@wp.struct
class PhotonNode:
    """What a search reads of a node, side by side: lower, upper: the box of its photons, turned inside out where it has
    none; facing: bits of the directions that their normals are near to; photons: how many there are.
    """

    lower: wp.vec3
    facing: int
    upper: wp.vec3
    photons: int


@wp.struct
class PhotonTree:
    """The hierarchy over the photons of one map.

    levels: below the root; leaves: the number of the first one. nodes (node,); flow (node,): sum of flux times normal,
    by brightness [W].
    """

    photons: Photons
    levels: int
    leaves: int
    nodes: wp.array[PhotonNode]
    flow: wp.array[wp.vec3]


def allocate_tree(photons: Photons, usual: int | None = None) -> PhotonTree:
    """A tree for all photons that there may be; usual: how many there mostly are, where that is less: with more of them
    leaves hold more.
    """
    levels = levels_of(min(usual or len(photons.flux), len(photons.flux)), PER_LEAF)
    tree: PhotonTree = allocate(PhotonTree, 2 << levels, photons.flux.device)
    tree.photons, tree.levels, tree.leaves = photons, levels, 1 << levels
    return tree


@wp.func
def direction_number(normal: wp.vec3) -> int:
    """Which of 26 directions, those to the neighbours of a cube in a grid, a normal is near to: within 33°."""
    number = int(0)
    for axis in range(3):
        step = wp.where(normal[axis] > DIAGONAL, 2, wp.where(normal[axis] < -DIAGONAL, 0, 1))
        number = 3 * number + step
    return number


@wp.func
def directions_about(normal: wp.vec3, threshold: float) -> int:
    """Bits of the directions that normals may be near to whose cosine with `normal` is more than `threshold`."""
    least = threshold * COS_NEAR - wp.sqrt(1.0 - threshold * threshold) * SIN_NEAR
    bits = int(0)
    for number in range(27):
        direction = wp.vec3(float(number // 9 - 1), float(number // 3 % 3 - 1), float(number % 3 - 1))
        if wp.dot(direction, normal) > least * wp.length(direction):
            bits = bits | (1 << number)
    return bits


@wp.kernel
def photon_leaf_kernel(first: int, tree: PhotonTree) -> None:
    """One thread a leaf: what it holds."""
    number = first + wp.tid()
    count = tree.photons.count[0]
    begin, end = run_begin(count, tree.levels, number), run_begin(count, tree.levels, number + 1)
    node = PhotonNode()
    node.lower = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
    node.upper = -node.lower
    node.photons = end - begin
    flow = wp.vec3(0.0, 0.0, 0.0)
    for photon in range(begin, end):
        node.lower = wp.min(node.lower, tree.photons.position[photon])
        node.upper = wp.max(node.upper, tree.photons.position[photon])
        node.facing = node.facing | (1 << direction_number(tree.photons.normal[photon]))
        flow += tree.photons.normal[photon] * brightness(tree.photons.flux[photon])
    tree.nodes[tree.leaves + number] = node
    tree.flow[tree.leaves + number] = flow


@wp.kernel
def photon_node_kernel(first: int, begin: int, tree: PhotonTree) -> None:
    """One thread a node of the level that begins with node `begin`: what both children hold."""
    number = begin + first + wp.tid()
    left, right = tree.nodes[2 * number], tree.nodes[2 * number + 1]
    node = PhotonNode()
    node.lower = wp.min(left.lower, right.lower)
    node.upper = wp.max(left.upper, right.upper)
    node.facing = left.facing | right.facing
    node.photons = left.photons + right.photons
    tree.nodes[number] = node
    tree.flow[number] = tree.flow[2 * number] + tree.flow[2 * number + 1]


def build_tree(tree: PhotonTree) -> None:
    """Fill in the nodes for the photons that there are now."""
    device = tree.flow.device
    launch(photon_leaf_kernel, tree.leaves, [tree], device)
    for level in reversed(range(tree.levels)):
        launch(photon_node_kernel, 1 << level, [1 << level, tree], device)


@wp.func
def box_offset(lower: wp.vec3, upper: wp.vec3, position: wp.vec3) -> wp.vec3:
    """From the nearest point of a box to `position`, each axis without its sign; 0 within the box."""
    return wp.max(wp.max(lower - position, position - upper), wp.vec3(0.0, 0.0, 0.0))


@wp.func
def least_separation(node: PhotonNode, alike: ClusteringParameters, facing: int, position: wp.vec3,
                     normal: wp.vec3) -> float:  # fmt: skip
    """What the separation of a surface point from photons in a node is at least; far away if none of them faces one of
    the directions `facing`.
    """
    if (node.facing & facing) == 0:
        return FAR_AWAY
    offset = box_offset(node.lower, node.upper, position)
    extent = 0.5 * wp.dot(wp.abs(normal), node.upper - node.lower)
    plane = wp.max(wp.abs(wp.dot(normal, 0.5 * (node.lower + node.upper) - position)) - extent, 0.0)
    return wp.sqrt(wp.length_sq(offset) + (alike.plane_weight * alike.plane_weight - 1.0) * plane * plane)


@cache
def photon_search(number: int) -> wp.Function:
    """The function that finds the `number` photons nearest to one of them, on its side.

    search(tree, alike, own, reach, lane, lanes) has `radius`, the distance of the farthest, or `reach` where there are
    fewer within that; and `distance` and `photon` of those that a lane (gpu.core.intrinsics) keeps, in the first
    number / lanes elements: −1 where there are no more within `reach`. Distances are stretched along the normals, and
    those of photons with unlike normals are not looked at (`alike`): what arrives on the other side of a wall or on the
    wall beside tells nothing, nor does it widen the estimate.

    It begins at the photon's own leaf and goes on with what lies beside the way from there to the root, from below:
    from the root down, whatever comes first fills the list, and three times as many photons get into it. The list is a
    heap, whose first element is the farthest: in a sorted one half of all would move for each that comes.

    Of nodes it looks at TOGETHER at once, all that are three levels below one: side by side in memory, they are shared
    by the lanes. It goes on with the nearest, and comes back for the next nearest until none is near enough.

    Lanes walk down to leaves with as many times more photons, and look at a photon each. Every lane has a heap; what
    comes nearer than the farthest of all takes the place of that, so all heaps together hold the same photons as one
    would. Some searches read ten thousand photons, where many are near but few alike, and a GPU would wait for the one
    thread that does.
    """
    distances: Any = wp.types.vector(length=number, dtype=float)
    indices: Any = wp.types.vector(length=number, dtype=int)

    @wp.struct
    class NearestPhotons:
        radius: float
        distance: distances
        photon: indices

    @wp.func
    def search(tree: PhotonTree, alike: ClusteringParameters, own: int, reach: float, lane: int,
               lanes: int) -> NearestPhotons:  # fmt: skip
        # In vectors of their own: one in a struct is copied whole wherever its elements are numbered by a variable.
        near_distance = distances()
        near_photon = indices()
        for f in range(wp.static(number)):
            near_distance[f] = reach
            near_photon[f] = -1
        position = tree.photons.position[own]
        normal = tree.photons.normal[own]
        facing = directions_about(normal, alike.normal_threshold)
        count = tree.photons.count[0]
        held = wp.static(number) // lanes
        farthest = float(reach)
        above = wp.min(bit_count(wp.uint32(lanes - 1)), tree.levels)
        levels = tree.levels - above
        leaves = tree.leaves >> above
        each = TOGETHER // lanes
        least = NodeDistances()
        level = int(levels)
        highest = int(levels) + 1  # level beside whose nodes on the way up was looked
        passed = int(0)
        first = (leaves + (run_holding(count, tree.levels, own) >> above)) // TOGETHER * TOGETHER
        enters = bool(True)
        while level >= 0:
            row = level // LEVELS_A_STEP * each
            if enters:
                for part in range(each):
                    other = first + part * lanes + lane
                    least[row + part] = FAR_AWAY
                    if (other >> level) == 1 and other != passed:
                        least[row + part] = least_separation(tree.nodes[other], alike, facing, position, normal)
            highest = wp.min(level, highest)
            pick = int(row)
            for part in range(row + 1, row + each):
                pick = wp.where(least[part] < least[pick], part, pick)
            if float_least(least[pick], lanes) >= farthest:
                passed = first // TOGETHER
                first = passed // TOGETHER * TOGETHER
                level -= LEVELS_A_STEP
                enters = level < highest
                continue
            candidate = first + (pick - row) * lanes + lane
            node = place_of_least(least[pick], candidate, lanes)
            if node == candidate:
                least[pick] = FAR_AWAY
            enters = level < levels
            if enters:
                first = TOGETHER * node
                level += LEVELS_A_STEP
                continue
            end = run_begin(count, levels, node - leaves + 1)
            for begin in range(run_begin(count, levels, node - leaves), end, lanes):
                distance = float(FAR_AWAY)
                photon = begin + lane
                if photon < end and photon != own:
                    photon_normal = tree.photons.normal[photon]
                    if wp.dot(photon_normal, normal) > alike.normal_threshold:
                        distance = separation(alike, position, normal, tree.photons.position[photon], photon_normal)
                nearest = float_least(distance, lanes)
                while nearest < farthest:
                    nearer = place_of_least(distance, photon, lanes)
                    if lane == place_of_least(-near_distance[0], lane, lanes):
                        place = int(0)
                        child = int(1)
                        while child < held:
                            sibling = wp.min(child + 1, held - 1)
                            child = wp.where(near_distance[sibling] > near_distance[child], sibling, child)
                            if near_distance[child] <= nearest:
                                child = held
                            else:
                                near_distance[place] = near_distance[child]
                                near_photon[place] = near_photon[child]
                                place = child
                                child = 2 * place + 1
                        near_distance[place] = nearest
                        near_photon[place] = nearer
                    if photon == nearer:
                        distance = FAR_AWAY
                    farthest = -float_least(-near_distance[0], lanes)
                    nearest = float_least(distance, lanes)
        found = NearestPhotons()
        found.radius = farthest
        found.distance = near_distance
        found.photon = near_photon
        return found

    return search

"""How much the geometry of shading points varies, and seeds of clusters where it does: 2009 paper, section 3.2.

The paper's quadtree over pixels is here a binary tree over the list of SPs, which is in Morton order (two levels are
one of a quadtree), so that pixels without a surface cost nothing.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.core.parameters import parameters
from gpu.core.range_tree import levels_of, run_begin
from gpu.sampling.sobol import TO_UNIT, hashed

# SPs of a leaf at most; seeds spread evenly over its list.
PER_LEAF = 4


@wp.struct
@dataclass
class SeedingParameters:
    """position_weight: α of Eq. 2; even_share: of a node's seeds, are shared between its children by how many SPs these
    have, the others by their variation: else flat walls, on which light changes, too, would get next to none.
    iterations: of k-means.
    """

    position_weight: float = 0.3
    even_share: float = 0.5
    iterations: int = 3


SEEDING_PARAMETERS: SeedingParameters = parameters(SeedingParameters)


@wp.struct
class VariationTree:
    """The mean position and normal (node,) of each node's SPs, and their sum of squared distances from the former."""

    levels: int
    leaves: int
    mean: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    squares: wp.array[float]


def allocate_variation_tree(capacity: int, device: wp.Device) -> VariationTree:
    """A tree for so many SPs."""
    levels = levels_of(capacity, PER_LEAF)
    tree: VariationTree = allocate(VariationTree, 2 << levels, device)
    tree.levels, tree.leaves = levels, 1 << levels
    return tree


@wp.kernel
def variation_leaf_kernel(first: int, points: Points, tree: VariationTree) -> None:
    """One thread a leaf: moments of its SPs."""
    number = first + wp.tid()
    node = tree.leaves + number
    begin = run_begin(points.count[0], tree.levels, number)
    end = run_begin(points.count[0], tree.levels, number + 1)
    size = float(wp.max(end - begin, 1))
    mean = wp.vec3(0.0, 0.0, 0.0)
    normal = wp.vec3(0.0, 0.0, 0.0)
    for point in range(begin, end):
        mean += points.position[point] / size
        normal += points.normal[point] / size
    squares = float(0.0)
    for point in range(begin, end):
        squares += wp.length_sq(points.position[point] - mean)
    tree.mean[node] = mean
    tree.normal[node] = normal
    tree.squares[node] = squares


@wp.kernel
def variation_node_kernel(first: int, level: int, points: Points, tree: VariationTree) -> None:
    """One thread a node of a level: moments of both children's SPs together (Chan et al., Updating Formulae, 1979)."""
    number = first + wp.tid()
    node = (1 << level) + number
    begin = run_begin(points.count[0], level, number)
    middle = run_begin(points.count[0], level + 1, 2 * number + 1)
    end = run_begin(points.count[0], level, number + 1)
    size = float(wp.max(end - begin, 1))
    left = float(middle - begin) / size
    right = float(end - middle) / size
    between = tree.mean[2 * node + 1] - tree.mean[2 * node]
    tree.mean[node] = tree.mean[2 * node] * left + tree.mean[2 * node + 1] * right
    tree.normal[node] = tree.normal[2 * node] * left + tree.normal[2 * node + 1] * right
    squares = tree.squares[2 * node] + tree.squares[2 * node + 1]
    tree.squares[node] = squares + wp.length_sq(between) * left * right * size


def build_variation_tree(points: Points, tree: VariationTree) -> None:
    """Fill in the nodes for `points`."""
    device = tree.mean.device
    launch(variation_leaf_kernel, tree.leaves, [points, tree], device)
    for level in reversed(range(tree.levels)):
        launch(variation_node_kernel, 1 << level, [level, points, tree], device)


@wp.func
def variation(chosen: SeedingParameters, tree: VariationTree, node: int, size: int) -> float:
    """ε of Eq. 2 of a node's `size` SPs about their mean: roots of mean squares, summed over the SPs."""
    if size == 0:
        return 0.0
    spread = wp.sqrt(tree.squares[node] / float(size))
    bend = wp.sqrt(wp.max(2.0 - 2.0 * wp.length(tree.normal[node]), 0.0))
    return float(size) * (chosen.position_weight * spread + bend)


@wp.struct
class SeededRun:
    """A run of SPs that one seed stands for: from `begin` to `end`."""

    begin: int
    end: int


@wp.func
def seeded_run(chosen: SeedingParameters, points: Points, tree: VariationTree, seeds: int, sought_seed: int,
               sought_point: int, random: int) -> SeededRun:  # fmt: skip
    """The run of one of `seeds` seeds, that of number `sought_seed`, or if that is −1, that which `sought_point` is in;
    empty where a node has more seeds than SPs.

    Each node gives its seeds to its children in proportion to their variation; what is left over goes by chance. Nodes
    where an SP is and no seed is are part of the run of their parent.
    """
    count = points.count[0]
    node = int(1)
    level = int(0)
    left_out = int(sought_seed)
    run = SeededRun()
    run.end = count
    while seeds > 1 and level < tree.levels:
        number = node - (1 << level)
        middle = run_begin(count, level + 1, 2 * number + 1)
        size = run.end - run.begin
        left_weight = variation(chosen, tree, 2 * node, middle - run.begin)
        weight = left_weight + variation(chosen, tree, 2 * node + 1, run.end - middle)
        even = float(middle - run.begin) / float(wp.max(size, 1))
        share = wp.where(weight > 0.0, left_weight / wp.max(weight, 1.0e-20), even)
        share += (even - share) * chosen.even_share
        chance = float(hashed(wp.uint32(node) ^ hashed(wp.uint32(random)))) * TO_UNIT
        left_seeds = wp.min(int(share * float(seeds) + chance), seeds)
        goes_left = left_out < left_seeds
        if sought_seed < 0:
            goes_left = sought_point < middle
        level += 1
        if goes_left:
            if left_seeds == 0:
                return run
            node = 2 * node
            run.end = middle
            seeds = left_seeds
        else:
            if left_seeds == seeds:
                return run
            node = 2 * node + 1
            run.begin = middle
            left_out -= left_seeds
            seeds -= left_seeds
    if seeds > 1:
        # The seeds of a leaf share its SPs evenly.
        size = run.end - run.begin
        begin = run.begin
        if sought_seed < 0:
            left_out = ((sought_point - begin + 1) * seeds - 1) // wp.max(size, 1)
        run.begin = begin + left_out * size // seeds
        run.end = begin + (left_out + 1) * size // seeds
    return run

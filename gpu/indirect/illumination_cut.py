"""A cut through the tree over photons, whose few nodes stand for all of them (2009 paper, section 3.3).

A coarse cut has bright nodes down to one level and dark ones above it. Then nodes whose irradiance is not what their
box tells are replaced by their children, in two rounds.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.device import allocate, launch
from gpu.core.parameters import parameters
from gpu.core.radix_sort import running_total
from gpu.core.range_tree import run_begin
from gpu.device_scene.data import SceneData
from gpu.lights.photon_density import PhotonSites, allocate_sites, estimate_density, estimate_irradiance
from gpu.lights.photon_tree import PhotonTree

# Of refinement: the coarse cut has a quarter to half as many nodes as there is room for.
ROUNDS = 2


@wp.struct
@dataclass
class CutParameters:
    """max_change: ∆E, of a node's approximate irradiance; where the accurate one differs by more, it is refined.

    Eq. 3 tells half of even light where a box is half a square, a change of 1.
    """

    max_change: float = 1.2


CUT_PARAMETERS: CutParameters = parameters(CutParameters)


@wp.struct
class CutNodes:
    """A list of nodes of a tree. node, level (entry,): which ones; count (1,): how many; splits (entry,): 1 for one
    that is to be replaced by its children, splits_total (entry,): the running sum of that.
    """

    node: wp.array[int]
    level: wp.array[int]
    count: wp.array[int]
    splits: wp.array[int]
    splits_total: wp.array[int]


@wp.struct
class CoarseCut:
    """What the coarse cut is chosen by. level: of its deepest nodes; density_sum (node,): of approximate irradiance
    over the nodes of that level below; chosen (node,): 1 for a bright node, 2 where one below is, else 0; member
    (node,): 1 in the cut, else 0; total (node,): the running sum of that.
    """

    level: int
    density_sum: wp.array[float]
    chosen: wp.array[int]
    member: wp.array[int]
    total: wp.array[int]


@wp.func
def node_size(tree: PhotonTree, node: int) -> float:
    """The longest side of a node's box, 0 for one without photons."""
    sides = tree.nodes[node].upper - tree.nodes[node].lower
    return wp.max(wp.max(sides[0], wp.max(sides[1], sides[2])), 0.0)


@wp.func
def approximate_irradiance(tree: PhotonTree, node: int) -> float:
    """Ẽ of Eq. 3: a node's flux over the square of its longest side.

    Flux is what crosses the plane of the node's mean normal: what photons bring is no less for the angle at which it
    comes, which the equation as printed counts twice.
    """
    size = node_size(tree, node)
    return wp.length(tree.flow[node]) / wp.max(size * size, 1.0e-12)


@wp.kernel
def density_sum_kernel(first: int, level: int, tree: PhotonTree, coarse: CoarseCut) -> None:
    """One thread a node of a level: its own approximate irradiance, on the deepest one, else what its children have."""
    node = (1 << level) + first + wp.tid()
    if level == coarse.level:
        coarse.density_sum[node] = approximate_irradiance(tree, node)
    else:
        coarse.density_sum[node] = coarse.density_sum[2 * node] + coarse.density_sum[2 * node + 1]


@wp.kernel
def coarse_cut_kernel(first: int, level: int, tree: PhotonTree, coarse: CoarseCut) -> None:
    """One thread a node of a level: 1 where it is bright, or 2 where one below is, which takes its place."""
    node = (1 << level) + first + wp.tid()
    least = coarse.density_sum[1] / float(1 << coarse.level)
    chosen = int(0)
    if approximate_irradiance(tree, node) > least:
        chosen = 1
    if level < coarse.level:
        below = coarse.chosen[2 * node] + coarse.chosen[2 * node + 1]
        chosen = wp.where(below > 0, 2, chosen)
    coarse.chosen[node] = chosen


@wp.kernel
def cut_member_kernel(first: int, tree: PhotonTree, coarse: CoarseCut) -> None:
    """One thread a node: 1 in the cut: bright, or dark beside a node that is above bright ones; else 0."""
    node = first + wp.tid()
    coarse.member[node] = 0
    if node == 0:
        return
    under_split = node == 1
    if node > 1:
        under_split = coarse.chosen[node // 2] == 2
    if under_split and coarse.chosen[node] != 2 and tree.nodes[node].photons > 0:
        coarse.member[node] = 1


@wp.kernel
def list_cut_kernel(first: int, coarse: CoarseCut, cut: CutNodes) -> None:
    """One thread a node: lists it if it is in the cut; the last one writes the list's length."""
    node = first + wp.tid()
    if coarse.member[node] == 1:
        level = int(0)
        while (node >> level) > 1:
            level += 1
        cut.node[coarse.total[node] - 1] = node
        cut.level[coarse.total[node] - 1] = level
    if node == coarse.total.shape[0] - 1:
        cut.count[0] = coarse.total[node]


@wp.kernel
def cut_site_kernel(first: int, tree: PhotonTree, cut: CutNodes, sites: PhotonSites) -> None:
    """One thread an entry: its site, the photon in the middle of the node's, which is on a surface."""
    entry = first + wp.tid()
    if entry == 0:
        sites.count[0] = cut.count[0]
    if entry < cut.count[0]:
        number = cut.node[entry] - (1 << cut.level[entry])
        begin = run_begin(tree.photons.count[0], cut.level[entry], number)
        end = run_begin(tree.photons.count[0], cut.level[entry], number + 1)
        sites.photon[entry] = (begin + end) // 2
        sites.flux[entry] = wp.length(tree.flow[cut.node[entry]])


@wp.kernel
def mark_splits_kernel(first: int, tree: PhotonTree, chosen: CutParameters, sites: PhotonSites, cut: CutNodes) -> None:
    """One thread an entry: whether its irradiance is unlike what its box tells, and both children have photons."""
    entry = first + wp.tid()
    cut.splits[entry] = 0
    if entry >= cut.count[0] or cut.level[entry] >= tree.levels:
        return
    node = cut.node[entry]
    if tree.nodes[2 * node].photons == 0 or tree.nodes[2 * node + 1].photons == 0:
        return
    expected = approximate_irradiance(tree, node)
    found = sites.irradiance[entry]
    accurate = (found[0] + found[1] + found[2]) / 3.0
    if wp.abs(accurate - expected) > chosen.max_change * expected:
        cut.splits[entry] = 1


@wp.kernel
def split_kernel(first: int, cut: CutNodes, out: CutNodes) -> None:
    """One thread an entry: writes it, or its children, to the next round's list, as long as there is room for them."""
    entry = first + wp.tid()
    count = cut.count[0]
    if entry >= count:
        return
    room = out.node.shape[0] - count
    before = cut.splits_total[entry] - cut.splits[entry]
    place = entry + wp.min(before, room)
    node = cut.node[entry]
    level = cut.level[entry]
    out.node[place] = node
    out.level[place] = level
    if cut.splits[entry] == 1 and before < room:
        out.node[place] = 2 * node
        out.level[place] = level + 1
        out.node[place + 1] = 2 * node + 1
        out.level[place + 1] = level + 1
    if entry == count - 1:
        out.count[0] = count + wp.min(cut.splits_total[entry], room)


def _allocate_nodes(capacity: int, device: wp.Device) -> CutNodes:
    nodes: CutNodes = allocate(CutNodes, capacity, device)
    nodes.count = wp.zeros(1, dtype=int, device=device)
    return nodes


class IlluminationCut:
    """Chooses at most `size` nodes of `tree`: `nodes` after `choose`, and `sites`, a photon of each and its irradiance.

    The coarse cut goes down to the level that has a quarter to half as many nodes, so that there is room for others.
    """

    def __init__(self, tree: PhotonTree, size: int, chosen: CutParameters = CUT_PARAMETERS) -> None:
        device = self.device = tree.flow.device
        self.tree, self.chosen, self.size = tree, chosen, size
        self._coarse = CoarseCut()
        self._coarse.level = min(max(size.bit_length() - 2, 0), tree.levels)
        for name, dtype in (("density_sum", float), ("chosen", int), ("member", int), ("total", int)):
            setattr(self._coarse, name, wp.zeros(2 << self._coarse.level, dtype=dtype, device=device))
        self.nodes, self._next = (_allocate_nodes(size, device) for _ in range(2))
        self.sites = allocate_sites(size, device)

    def choose(self, scene: SceneData) -> None:
        """Choose the nodes for the photons that there are now, and tell the irradiance at them."""
        tree, sites, device = self.tree, self.sites, self.device
        self._choose_coarse()
        for _ in range(ROUNDS):
            launch(cut_site_kernel, self.size, [tree, self.nodes, sites], device)
            estimate_density(tree, sites)
            launch(mark_splits_kernel, self.size, [tree, self.chosen, sites, self.nodes], device)
            running_total(self.nodes.splits, self.nodes.splits_total)
            self._next.count.zero_()
            launch(split_kernel, self.size, [self.nodes, self._next], device)
            for name in ("node", "level", "count"):
                wp.copy(getattr(self.nodes, name), getattr(self._next, name))
        launch(cut_site_kernel, self.size, [tree, self.nodes, sites], device)
        estimate_irradiance(scene, tree, sites)

    def _choose_coarse(self) -> None:
        coarse, device = self._coarse, self.device
        for kernel in (density_sum_kernel, coarse_cut_kernel):
            for level in reversed(range(coarse.level + 1)):
                launch(kernel, 1 << level, [level, self.tree, coarse], device)
        launch(cut_member_kernel, 2 << coarse.level, [self.tree, coarse], device)
        running_total(coarse.member, coarse.total)
        launch(list_cut_kernel, 2 << coarse.level, [coarse, self.nodes], device)

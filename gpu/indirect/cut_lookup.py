"""What a final-gather ray reads of an illumination cut: irradiance between its nodes by radial basis functions.

2009 paper, section 3.3, Eq. 4 and 5.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import separation
from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.core.range_tree import NodeStack
from gpu.device_scene.data import SceneData
from gpu.indirect.illumination_cut import CutNodes, IlluminationCut, node_size
from gpu.lights.photon_density import NEIGHBOURS, PhotonSites, answers
from gpu.lights.photon_tree import PhotonTree, box_offset

# Of the second function beside Eq. 4: any that is next to nothing.
TAIL_WEIGHT = wp.constant(1.0e-3)


@wp.struct
@dataclass
class CutLookupParameters:
    """reach: r of Eq. 4, in longest sides of a node's box, which count as one radius of the estimate at least, and as
    most_radii of a disk of all their photons at most: boxes that the Morton order has run through two places are wide,
    and tell of neither. tail_reach: a second function, so much wider and next to nothing beside a node that reaches a
    point, answers where none does, which would be dark.
    """

    reach: float = 1.0
    most_radii: float = 2.0
    tail_reach: float = 2.0


CUT_LOOKUP_PARAMETERS: CutLookupParameters = parameters(CutLookupParameters)


@wp.struct
class CutMap:
    """A cut as rays read it: site (node,): that of a node in the cut, else −1; lower, upper (node,): box of all that
    the nodes of the cut below reach; reach (site,): r of Eq. 4.
    """

    chosen: CutLookupParameters
    tree: PhotonTree
    sites: PhotonSites
    site: wp.array[int]
    lower: wp.array[wp.vec3]
    upper: wp.array[wp.vec3]
    reach: wp.array[float]


@wp.kernel
def forget_sites_kernel(first: int, lit: CutMap) -> None:
    """One thread a node: is not in the cut, and reaches nothing."""
    node = first + wp.tid()
    lit.site[node] = -1
    lit.lower[node] = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
    lit.upper[node] = -lit.lower[node]


@wp.kernel
def cut_reach_kernel(first: int, cut: CutNodes, lit: CutMap) -> None:
    """One thread an entry of the cut: how far it reaches."""
    entry = first + wp.tid()
    if entry >= cut.count[0]:
        return
    node = cut.node[entry]
    radius = lit.sites.radius[entry]
    photons = float(lit.tree.photons.count[0]) / float(1 << cut.level[entry])
    widest = lit.chosen.most_radii * radius * wp.sqrt(wp.max(photons / float(wp.static(NEIGHBOURS)), 1.0))
    reach = lit.chosen.reach * wp.clamp(node_size(lit.tree, node), radius, widest)
    position = lit.tree.photons.position[lit.sites.photon[entry]]
    lit.reach[entry] = reach
    lit.site[node] = entry
    tail = lit.chosen.tail_reach * reach
    lit.lower[node] = position - wp.vec3(tail, tail, tail)
    lit.upper[node] = position + wp.vec3(tail, tail, tail)


@wp.kernel
def join_reach_kernel(first: int, level: int, lit: CutMap) -> None:
    """One thread a node of a level: what its children reach, if it is not in the cut itself."""
    node = (1 << level) + first + wp.tid()
    if lit.site[node] < 0:
        lit.lower[node] = wp.min(lit.lower[2 * node], lit.lower[2 * node + 1])
        lit.upper[node] = wp.max(lit.upper[2 * node], lit.upper[2 * node + 1])


def cut_map(cut: IlluminationCut, chosen: CutLookupParameters = CUT_LOOKUP_PARAMETERS) -> CutMap:
    """Room for what rays read of `cut`."""
    lit, nodes, device = CutMap(), 2 << cut.deepest, cut.device
    lit.chosen, lit.tree, lit.sites = chosen, cut.tree, cut.sites
    lit.site = wp.zeros(nodes, dtype=int, device=device)
    lit.lower, lit.upper = (wp.zeros(nodes, dtype=wp.vec3, device=device) for _ in range(2))
    lit.reach = wp.zeros(cut.size, dtype=float, device=device)
    return lit


def map_cut(cut: IlluminationCut, lit: CutMap) -> None:
    """Fill in `lit` for the nodes of `cut`."""
    device = cut.device
    launch(forget_sites_kernel, len(lit.site), [lit], device)
    launch(cut_reach_kernel, cut.size, [cut.nodes, lit], device)
    for level in reversed(range(cut.deepest)):
        launch(join_reach_kernel, 1 << level, [level, lit], device)


@wp.func
def irradiance_in_cut(scene: SceneData, lit: CutMap, position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """Irradiance of a surface point [W/m²]: the mean of the nodes that reach it, by Eq. 4 with distances stretched
    along the normals, so that no light comes through thin walls and shelves.
    """
    light = wp.vec3(0.0, 0.0, 0.0)
    total = float(0.0)
    stack = NodeStack()
    stack[0] = 1
    top = int(1)
    while top > 0:
        top -= 1
        node = stack[top]
        if wp.length_sq(box_offset(lit.lower[node], lit.upper[node], position)) > 0.0:
            continue
        site = lit.site[node]
        if site < 0:
            stack[top] = 2 * node
            stack[top + 1] = 2 * node + 1
            top += 2
            continue
        photon = lit.sites.photon[site]
        other = lit.tree.photons.normal[photon]
        facing = wp.dot(normal, other)
        if facing > 0.0:
            away = separation(lit.sites.alike, position, normal, lit.tree.photons.position[photon], other)
            share = away / wp.max(lit.reach[site], 1.0e-9)
            tail = TAIL_WEIGHT * (1.0 - share * share / (lit.chosen.tail_reach * lit.chosen.tail_reach))
            weight = (wp.max(1.0 - share * share, 0.0) + tail) * facing
            if weight > 0.0:
                open_way = answers(scene, lit.tree, lit.sites, site, position, normal)
                if open_way:
                    light += lit.sites.irradiance[site] * weight
                    total += weight
    return light / wp.max(total, 1.0e-12)


class CutLight:
    """What rays read of a cut of at most `size` nodes of `tree`; as gpu.indirect.photon_lookup.FullMapLight."""

    data, lookup = CutMap, irradiance_in_cut

    def __init__(self, tree: PhotonTree, size: int) -> None:
        self.cut = IlluminationCut(tree, size)
        self.lit = cut_map(self.cut)

    def estimate(self, scene: SceneData) -> None:
        """Choose the cut for the photons that there are now, and tell the irradiance at its nodes."""
        self.cut.choose(scene)
        map_cut(self.cut, self.lit)

"""What a final-gather ray reads of an illumination cut: irradiance between its nodes by radial basis functions.

2009 paper, section 3.3, Eq. 4 and 5. A grid of the disks that nodes reach takes the place of the tree above the cut,
whose boxes overlap.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import separation
from gpu.core.device import launch
from gpu.core.intrinsics import lanes_of
from gpu.core.parameters import parameters
from gpu.device_scene.data import WHOLE, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import made_for, masks_of, specialisation
from gpu.indirect.illumination import IrradianceEstimate
from gpu.indirect.illumination_cut import CutNodes, IlluminationCut, node_size
from gpu.lights.disk_grid import CORNERS, LEVELS, DiskGrid, DiskGridBuilder, bucket_at, disk_level, reaches
from gpu.lights.photon_density import NEIGHBOURS, PhotonSites, covered_disk, disk_places
from gpu.lights.photon_tree import PhotonTree


@wp.struct
@dataclass
class CutLookupParameters:
    """reach: r of Eq. 4, in longest sides of a node's box, which count as one radius of the estimate at least, and as
    most_radii of a disk of all their photons at most: boxes that the Morton order has run through two places are wide,
    and tell of neither. most_reach: of any node, unit space.
    """

    reach: float = 1.0
    most_radii: float = 2.0
    most_reach: float = 0.2


CUT_LOOKUP_PARAMETERS: CutLookupParameters = parameters(CutLookupParameters)


@wp.struct
class CutMap:
    """A cut as rays read it. position, normal (node,): of a node's photon; reach (node,): r of Eq. 4; free (node,): how
    much of that is surface all around, which is what it answers for; grid: of these disks.
    """

    chosen: CutLookupParameters
    tree: PhotonTree
    sites: PhotonSites
    grid: DiskGrid
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    reach: wp.array[float]
    free: wp.array[float]


@made_for("masks", "alpha", "cutouts", "part_glass")
def cut_disk_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def cut_disk_kernel(first: int, lanes: int, scene: SceneData, cut: CutNodes, lit: CutMap) -> None:
        """`lanes` threads a node of the cut: how far it reaches."""
        index = first + wp.tid()
        scene = specialise(scene)
        scene.coverage = WHOLE
        entry = index // lanes
        lane = index % lanes
        if entry >= cut.count[0]:
            return
        radius = lit.sites.radius[entry]
        photons = float(lit.tree.photons.count[0]) / float(1 << cut.level[entry])
        widest = lit.chosen.most_radii * radius * wp.sqrt(wp.max(photons / float(wp.static(NEIGHBOURS)), 1.0))
        reach = lit.chosen.reach * wp.clamp(node_size(lit.tree, cut.node[entry]), radius, widest)
        reach = wp.min(reach, lit.chosen.most_reach)
        position = lit.tree.photons.position[lit.sites.photon[entry]]
        normal = lit.tree.photons.normal[lit.sites.photon[entry]]
        free = float(0.0)
        if lit.sites.free[entry] > 0.0:
            places = disk_places(entry, lit.tree.leaves)
            free = covered_disk(scene, lit.sites.alike, position, normal, reach, places, lane, lanes).free
        if lane == 0:
            lit.position[entry] = position
            lit.normal[entry] = normal
            lit.reach[entry] = reach
            lit.free[entry] = free

    return cut_disk_kernel


@wp.func
def irradiance_in_cut(lit: CutMap, position: wp.vec3, normal: wp.vec3) -> IrradianceEstimate:
    """What is known of the irradiance of a surface point: the mean of the nodes that reach it, by Eq. 4 with distances
    stretched along the normals, so that no light comes through thin walls and shelves.
    """
    light = wp.vec3(0.0, 0.0, 0.0)
    earlier = wp.vec3(0.0, 0.0, 0.0)
    total = float(0.0)
    for level in range(LEVELS):
        bucket = bucket_at(lit.grid, position, level, 1.0)
        for place in range(lit.grid.starts[bucket], lit.grid.starts[bucket + 1]):
            if reaches(lit.grid, place, position):
                node = lit.grid.entries[place] // CORNERS
                facing = wp.dot(normal, lit.normal[node])
                away = separation(lit.sites.alike, position, normal, lit.position[node], lit.normal[node])
                share = away / lit.reach[node]
                answers = facing > 0.0 and share < 1.0
                if answers and disk_level(lit.grid, lit.free[node], 1.0) == level:
                    weight = (1.0 - share * share) * facing
                    light += lit.sites.irradiance[node] * weight
                    earlier += lit.sites.earlier[node] * weight
                    total += weight
    estimate = IrradianceEstimate()
    estimate.known = total > 0.0
    estimate.irradiance = light / wp.max(total, 1.0e-12)
    estimate.earlier = earlier / wp.max(total, 1.0e-12)
    return estimate


class CutLight:
    """What rays read of a cut of at most `size` nodes of `tree`; as gpu.indirect.photon_lookup.FullMapLight."""

    data, lookup = CutMap, irradiance_in_cut

    def __init__(self, tree: PhotonTree, size: int) -> None:
        self.cut = IlluminationCut(tree, size)
        device = self.cut.device
        flatness = float(self.cut.sites.alike.plane_weight)
        self._disks = DiskGridBuilder(size, float(CUT_LOOKUP_PARAMETERS.most_reach), flatness, device)
        self._whole = wp.ones(1, dtype=float, device=device)
        self.lit = CutMap()
        self.lit.chosen, self.lit.tree = CUT_LOOKUP_PARAMETERS, tree
        self.lit.sites, self.lit.grid = self.cut.sites, self._disks.grid
        self.lit.position, self.lit.normal = (wp.zeros(size, dtype=wp.vec3, device=device) for _ in range(2))
        self.lit.reach, self.lit.free = (wp.zeros(size, dtype=float, device=device) for _ in range(2))

    def estimate(self, scene: SceneData) -> None:
        """Choose the cut for the photons that there are now, and tell the irradiance at its nodes."""
        cut, lit = self.cut, self.lit
        cut.choose(scene)
        lanes = lanes_of(cut.device, few=True)
        inputs = [lanes, scene, cut.nodes, lit]
        launch(cut_disk_kernel(masks_of(scene)), lanes * cut.size, inputs, cut.device)
        self._disks.build(lit.position, lit.normal, lit.free, self._whole, cut.nodes.count)

"""Radiosity of lit surfaces, from how densely VPLs lie on them: what a RadiosityCache keeps at the VPLs.

The estimate over nearest neighbours is that of photon maps (H. W. Jensen, Global Illumination using Photon Maps, 1996).
"""

import warp as wp

from gpu.clustering.grid import ClusteringParameters, Grid, Representatives, cells_per_unit
from gpu.clustering.nearest import nearest_search
from gpu.core.color import brightness
from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.core.intrinsics import lanes_of
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, WHOLE, SceneData
from gpu.device_scene.disk_coverage import surface_beside
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.radiosity_cache import RADIOSITY_PARAMETERS, RadiosityCache, RadiosityCells, RadiosityParameters
from gpu.vpl.vpl_clusters import VplClusters
from gpu.vpl.vpl_reflectance import find_reflectance

# VPLs in one estimate, itself among them: the length of vectors. The last only bounds the disk: the mean over a surface
# is unbiased with that.
NEIGHBOURS = 12
# Places around a VPL where its surface is looked for, by a ray each, at this share of its disk's radius: half of the
# area is nearer.
PLACES = wp.constant(8)
MIDDLE = wp.constant(0.70710678)


@wp.func
def straight_distance(
    chosen: ClusteringParameters, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3
) -> float:
    """Distance of two points, whatever their surfaces' normals are."""
    return wp.length(q - p)


neighbours = nearest_search(NEIGHBOURS, straight_distance)


@wp.kernel
def neighbour_spacing_kernel(first: int, clusters: VplClusters, most_area: float, number: wp.array[int], lanes: int,
                             vpls: Representatives) -> None:  # fmt: skip
    """`lanes` threads a cluster: its members' spacing, 0 if it has no extent: cells are of 1 to 2 radii of an estimate.

    number (1,): of all VPLs. A cluster of strays is far wider than its members are apart. Searching all of that would
    keep the others waiting.
    """
    index = first + wp.tid()
    cluster = index // lanes
    begin = clusters.starts[cluster]
    end = clusters.starts[cluster + 1]
    area = wp.min(clusters.disks[cluster].area / float(end - begin), most_area / float(number[0]))
    radius = wp.sqrt(float(wp.static(NEIGHBOURS)) * area / PI)
    for member in range(begin + index % lanes, end, lanes):
        vpls.spacing[member] = radius / vpls.chosen.cell_per_spacing


@wp.func
def is_glass(lit: RadiosityCache, vpl: int) -> bool:
    """Whether a VPL lies on frosted glass, whose light is not that of what is close behind."""
    if lit.reflectance.shape[0] == 0:
        return False
    return largest(lit.reflectance[vpl]) == 0.0


@wp.kernel
def radiosity_kernel(first: int, vpls: Representatives, clusters: VplClusters, lit: RadiosityCache) -> None:
    """One thread a VPL: flux per area of the disk that its neighbours fill, and that disk's radius; none on glass."""
    vpl = first + wp.tid()
    lit.radius[vpl] = 0.0
    lit.radiosity[vpl] = wp.vec3(0.0, 0.0, 0.0)
    if vpls.spacing[vpl] <= 0.0:
        return
    if is_glass(lit, vpl):
        return
    level = vpls.level[vpl]
    found = neighbours(vpls, vpls.position[vpl], vpls.normal[vpl], level)
    # Beyond a cell the search is not complete.
    disk = wp.min(found.distance[wp.static(NEIGHBOURS - 1)], 1.0 / cells_per_unit(level))
    if disk <= 0.0:
        return
    total = wp.vec3(0.0, 0.0, 0.0)
    path_total = wp.vec3(0.0, 0.0, 0.0)
    strongest = wp.vec3(0.0, 0.0, 0.0)
    path_strongest = wp.vec3(0.0, 0.0, 0.0)
    counted = int(0)
    for place in range(wp.static(NEIGHBOURS)):
        if found.distance[place] < disk:
            other = found.cluster[place]
            off = wp.dot(vpls.position[other] - vpls.position[vpl], vpls.normal[vpl])
            if wp.abs(off) < lit.chosen.plane_share * disk and not is_glass(lit, other):
                flux = clusters.members.flux[other]
                path_flux = clusters.path_flux[other]
                total += flux
                path_total += path_flux
                counted += 1
                if brightness(path_flux) > brightness(path_strongest):
                    strongest = flux
                    path_strongest = path_flux
    if counted > 1:
        most = lit.chosen.most_of_mean * brightness(path_total - path_strongest) / float(counted - 1)
        total = (total - strongest) + strongest * wp.min(most / brightness(path_strongest), 1.0)
    lit.radius[vpl] = disk
    lit.radiosity[vpl] = total / (PI * disk * disk)


@made_for("part_glass")
def disk_coverage_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def disk_coverage_kernel(first: int, scene: SceneData, lit: RadiosityCache, covered: wp.array[int]) -> None:
        """One thread a place around a VPL, in the middle of its disk's area: 1 where its surface goes on, else 0.

        covered: (vpl, place), flattened. The surface ends at its edge, and where something stands on it.
        """
        scene = specialise(scene)
        index = first + wp.tid()
        vpl = index // PLACES
        covered[index] = 0
        disk = lit.radius[vpl]
        if disk <= 0.0:
            return
        scene.coverage = WHOLE
        turn = (float(index % PLACES) + float(hashed(wp.uint32(vpl))) * TO_UNIT) * (2.0 * PI / float(PLACES))
        height = lit.chosen.plane_share * disk
        hit = surface_beside(scene, lit.position[vpl], lit.normal[vpl], turn, MIDDLE * disk, height)
        if hit.face == NO_HIT:
            return
        if wp.abs(wp.dot(triangle_normal(scene, hit.face), lit.normal[vpl])) > lit.alike.normal_threshold:
            covered[index] = 1

    return disk_coverage_kernel


@wp.kernel
def covered_radiosity_kernel(first: int, covered: wp.array[int], share: wp.array[float], lit: RadiosityCache) -> None:
    """One thread a VPL: its radiosity is that of the part of its disk that is surface; share (vpl,), or empty: of that,
    what is there.
    """
    vpl = first + wp.tid()
    number = int(0)
    for place in range(PLACES):
        number += covered[vpl * PLACES + place]
    lit.covered[vpl] = number
    lit.radiosity[vpl] = lit.radiosity[vpl] * float(PLACES) / float(wp.max(number, lit.chosen.least_covered))
    if share.shape[0] > 0:
        lit.radiosity[vpl] = lit.radiosity[vpl] / share[vpl]


class RadiosityBuilder:
    """Estimates the radiosity at the members of `clusters`, of which there is one or more: `cache`, in arrays that
    stay, for whatever these members are at the time.

    lobes: the scene's features where rays of specular lobes, or what is seen through, read the cache
    (gpu.vpl.radiosity_mean), else None.
    """

    def __init__(
        self,
        clusters: VplClusters,
        device: wp.Device,
        chosen: RadiosityParameters = RADIOSITY_PARAMETERS,
        number: wp.array | None = None,
        usual: int = 0,
        lobes: SceneFeatures | None = None,
    ) -> None:
        """`number` (1,): of the members that there are at the time, if not all; usual: about how many that is."""
        members, count = clusters.members, len(clusters.member_area)
        self._number = wp.full(1, count, dtype=int, device=device) if number is None else number
        self._clusters, self._chosen, self._lobes, self.device = clusters, chosen, lobes, device
        self._grid = Grid(count, device)
        vpls = self._grid.data
        vpls.position, vpls.normal = members.position, members.normal
        self.cache = RadiosityCache()
        self.cache.chosen, self.cache.alike = chosen, vpls.chosen
        self.cache.usual_area = chosen.most_area / (usual or count)
        self.cache.position, self.cache.normal = members.position, members.normal
        self.cache.radius = wp.zeros(count, dtype=float, device=device)
        self.cache.radiosity = wp.zeros(count, dtype=wp.vec3, device=device)
        if lobes:
            self.cache.reflectance = wp.zeros(count, dtype=wp.vec3, device=device)
        self.cache.covered = wp.zeros(count, dtype=int, device=device)
        self._covered = wp.zeros(int(PLACES) * count, dtype=int, device=device)
        self._share = wp.zeros(count if lobes and lobes.blend else 0, dtype=float, device=device)
        self._cells = RadiosityCells(self.cache, device, usual)

    def run(self, scene: SceneData) -> None:
        """Estimate it on the surfaces of `scene`, without leaving the device."""
        clusters, lit, vpls, covered, device = self._clusters, self.cache, self._grid.data, self._covered, self.device
        count = len(lit.radius)
        vpls.spacing.zero_()
        lanes = lanes_of(device, few=True)
        inputs = [clusters, self._chosen.most_area, self._number, lanes, vpls]
        launch(neighbour_spacing_kernel, lanes * clusters.count, inputs, device)
        self._grid.build()
        if self._lobes:
            find_reflectance(scene, self._lobes, lit.position, lit.normal, lit.reflectance, self._share)
        launch(radiosity_kernel, count, [vpls, clusters, lit], device)
        launch(disk_coverage_kernel(part_glass_of(scene)), int(PLACES) * count, [scene, lit, covered], device)
        launch(covered_radiosity_kernel, count, [covered, self._share, lit], device)
        self._cells.sort()

    def relight(self) -> None:
        """Estimate it again, where nothing but the members' flux has changed."""
        lit, count = self.cache, len(self.cache.radius)
        launch(radiosity_kernel, count, [self._grid.data, self._clusters, lit], self.device)
        launch(covered_radiosity_kernel, count, [self._covered, self._share, lit], self.device)

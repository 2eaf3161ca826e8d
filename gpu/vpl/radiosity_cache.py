"""Radiosity of lit surfaces, from how densely VPLs lie on them: what near-field light is looked up in.

The estimate over nearest neighbours is that of photon maps (H. W. Jensen, Global Illumination using Photon Maps, 1996),
kept at the VPLs (P. Christensen, Faster Photon Map Global Illumination, 1999), so that a look-up finds just one.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import (
    ClusteringParameters,
    Grid,
    Representatives,
    cell_at,
    cells_per_unit,
    level_of,
    separation,
)
from gpu.clustering.nearest import nearest_search
from gpu.core.color import brightness
from gpu.core.constants import PI
from gpu.core.device import launch, launch_together
from gpu.core.intrinsics import lanes_of
from gpu.core.morton import dominant_axis
from gpu.core.parameters import parameters
from gpu.core.radix_sort import Groups
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, WHOLE, SceneData
from gpu.device_scene.disk_coverage import surface_beside
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.vpl_clusters import VplClusters
from gpu.vpl.vpl_reflectance import find_reflectance

# VPLs in one estimate, itself among them: the length of vectors. The last only bounds the disk: the mean over a surface
# is unbiased with that.
NEIGHBOURS = 12
# Places around a VPL where its surface is looked for, by a ray each, at this share of its disk's radius: half of the
# area is nearer.
PLACES = wp.constant(8)
MIDDLE = wp.constant(0.70710678)
# A VPL stands in cells of so many sizes, each twice the one before: entries are encoded by their number.
LEVELS_HELD = wp.constant(3)
# Of cells wider than any scene: where no VPL knows anything.
NO_LEVEL = 32
# Cells are moved by so much, or walls would lie between them, those that bound unit space in all levels, and rounding
# would decide in which a point is.
CELLS_MOVED = wp.constant(wp.vec3(0.21371, 0.17317, 0.13193))


@wp.struct
@dataclass
class RadiosityParameters:
    """What decides the quality of estimates and of their look-up.

    plane_share: of the disk's radius; VPLs farther off the plane are of another surface. They bound the disk all the
    same, which is so no wider than slats are apart. most_area: neighbours are searched for no farther than if all VPLs
    lay evenly on so many unit squares. least_covered: of the PLACES; fewer that are surface are not believed, and
    near-field rays go on from there (gpu.indirect.near_field_paths).
    reach: a VPL answers for points within so many of its radii, stretched along the normals. cell_share: of radii, in
    spacings of gpu.clustering.grid: the smallest cell of a VPL has 0.75 to 1.5 radii, so that in its cells 2 to 140
    VPLs of a surface are about, of which a look-up reads most_read. levels_searched: what few VPLs far around say of a
    crack is noise. most_of_mean: the strongest VPL of an estimate counts as so many of the others at most: one that
    came a way few paths go would make a bright spot of what is a wide faint glow.
    """

    plane_share: float = 0.25
    most_area: float = 16.0
    least_covered: int = 3
    reach: float = 2.0
    cell_share: float = 0.5
    most_read: int = 12
    levels_searched: int = 9
    most_of_mean: float = 4.0


RADIOSITY_PARAMETERS: RadiosityParameters = parameters(RadiosityParameters)


@wp.func
def straight_distance(
    chosen: ClusteringParameters, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3
) -> float:
    """Distance of two points, whatever their surfaces' normals are."""
    return wp.length(q - p)


neighbours = nearest_search(NEIGHBOURS, straight_distance)


@wp.struct
class RadiosityCache:
    """VPLs that know the radiosity around them, in hashed cells, each of one size and of normals to one side.

    chosen: how it is made and read; alike: which points are. position, normal (vpl,); radius (vpl,): of the estimate's
    disk, 0 for none; radiosity (vpl,) [W/m²]; reflectance (vpl,): of its surface, where lobes read the cache; covered
    (vpl,): how many of the PLACES around are surface; usual_area: of a VPL, if all lay evenly on `most_area`.
    entries: encoded LEVELS_HELD·vpl + (level − own level), grouped by bucket; starts (bucket + 1,); lowest, highest
    (1,): the levels that entries have, NO_LEVEL and −1 where there is none.
    """

    chosen: RadiosityParameters
    alike: ClusteringParameters
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    radius: wp.array[float]
    radiosity: wp.array[wp.vec3]
    reflectance: wp.array[wp.vec3]
    covered: wp.array[int]
    entries: wp.array[int]
    starts: wp.array[int]
    usual_area: float
    buckets: int
    lowest: wp.array[int]
    highest: wp.array[int]


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


@wp.func
def is_narrow(lit: RadiosityCache, vpl: int) -> bool:
    """Whether so few places around a VPL are surface that how densely VPLs lie there tells little."""
    return lit.covered[vpl] < lit.chosen.least_covered


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


@wp.func
def bucket_around(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, level: int) -> int:
    """The place in the table of the cell of a level that holds a surface point. Cells may share one."""
    cell = cell_at(position + CELLS_MOVED, cells_per_unit(level))
    mixed = hashed(wp.uint32(6 * level + dominant_axis(normal)))
    for axis in range(3):
        mixed = hashed(mixed ^ wp.uint32(cell[axis]))
    return int(mixed & wp.uint32(lit.buckets - 1))


@wp.kernel
def radiosity_bucket_kernel(first: int, lit: RadiosityCache, buckets: wp.array[int]) -> None:
    """One thread an entry: its bucket, or `buckets` of the map where the VPL knows nothing."""
    entry = first + wp.tid()
    vpl = entry // LEVELS_HELD
    buckets[entry] = lit.buckets
    if lit.radius[vpl] > 0.0:
        level = level_of(lit.alike, lit.chosen.cell_share * lit.radius[vpl]) + entry % LEVELS_HELD
        buckets[entry] = bucket_around(lit, lit.position[vpl], lit.normal[vpl], level)


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


@wp.kernel
def radiosity_level_kernel(first: int, lit: RadiosityCache) -> None:
    """One thread a VPL: widens the levels that entries have by its own, if it knows something."""
    radius = lit.radius[first + wp.tid()]
    if radius > 0.0:
        level = level_of(lit.alike, lit.chosen.cell_share * radius)
        if level < lit.lowest[0]:
            wp.atomic_min(lit.lowest, 0, level)
        if level + LEVELS_HELD - 1 > lit.highest[0]:
            wp.atomic_max(lit.highest, 0, level + LEVELS_HELD - 1)


class RadiosityCells:
    """The cells of a cache, which it makes for its VPLs; their arrays are allocated once."""

    def __init__(self, lit: RadiosityCache, device: wp.Device, usual: int = 0) -> None:
        """usual: about how many VPLs there are, if fewer than there is room for: look-ups depend on it."""
        self._lit, entries = lit, LEVELS_HELD * len(lit.radius)
        lit.buckets = 1 << (LEVELS_HELD * (usual or len(lit.radius)) - 1).bit_length()
        lit.lowest, lit.highest = (wp.zeros(1, dtype=int, device=device) for _ in range(2))
        self._groups = Groups(entries, lit.buckets, device)
        lit.entries, lit.starts = self._groups.items, self._groups.starts

    def sort(self) -> None:
        """Sort the VPLs into cells by their radii."""
        lit, groups = self._lit, self._groups
        lit.lowest.fill_(NO_LEVEL)
        lit.highest.fill_(-1)
        launch_together(radiosity_level_kernel, len(lit.radius), [lit], groups.device)
        launch(radiosity_bucket_kernel, groups.capacity, [lit, groups.keys], groups.device)
        groups.sort()


@wp.func
def answering_vpl(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, first_level: int, end_level: int) -> int:
    """The VPL that answers for a surface point, of the first level from `first_level` on that knows one; −1 for none.

    All VPLs in a cell are of similar use, so it is enough to look at a few, that are spread evenly over their order,
    which follows the clusters.
    """
    vpl = int(-1)
    level = wp.max(first_level, lit.lowest[0])
    last_level = wp.min(end_level, lit.highest[0] + 1)
    while vpl < 0 and level < last_level:
        bucket = bucket_around(lit, position, normal, level)
        begin = lit.starts[bucket]
        end = lit.starts[bucket + 1]
        step = (end - begin + lit.chosen.most_read - 1) // lit.chosen.most_read
        best = lit.chosen.reach
        place = begin
        while place < end:
            candidate = lit.entries[place] // LEVELS_HELD
            candidate_normal = lit.normal[candidate]
            if wp.dot(candidate_normal, normal) > lit.alike.normal_threshold:
                away = separation(lit.alike, position, normal, lit.position[candidate], candidate_normal)
                away = away / lit.radius[candidate]
                if away < best:
                    best = away
                    vpl = candidate
            place += step
        level += 1
    return vpl


@wp.func
def vpl_around(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, scale: float) -> int:
    """The VPL that answers for a surface point, −1 where none is near; of radii far from `scale`, none is found."""
    level = level_of(lit.alike, scale)
    return answering_vpl(lit, position, normal, level, level + lit.chosen.levels_searched)


@wp.func
def lacking_area(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, scale: float) -> float:
    """The area of a VPL about a surface point, were there one, where `vpl_around` finds none for `scale`; 0 where VPLs
    lie, but densely.
    """
    if answering_vpl(lit, position, normal, lit.lowest[0], level_of(lit.alike, scale)) >= 0:
        return 0.0
    return lit.usual_area

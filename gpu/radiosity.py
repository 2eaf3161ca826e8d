"""Radiosity of lit surfaces, from how densely VPLs lie on them: what near-field light is looked up in.

The estimate over nearest neighbours is that of photon maps (H. W. Jensen, Global Illumination using Photon Maps, 1996),
kept at the VPLs (P. Christensen, Faster Photon Map Global Illumination, 1999), so that a look-up finds just one.
"""

import warp as wp

from gpu.device import launch
from gpu.grid import NORMAL_THRESHOLD, Grid, Representatives, cells_per_unit, level_of
from gpu.nearest import nearest_search
from gpu.rays import closest_hit, occluded
from gpu.resident import NO_HIT, ResidentScene, SceneData
from gpu.sampling import PI, TO_UNIT, hashed, orthonormal
from gpu.surface import triangle_normal
from gpu.vpl_clusters import VplClusters

# VPLs in one estimate, itself among them. The last only bounds the disk: the mean over a surface is unbiased with that.
NEIGHBOURS = 12
# VPLs off the plane by more than this share of the disk's radius are of another surface. They bound the disk all the
# same, which is so no wider than slats are apart.
PLANE_SHARE = wp.constant(0.3)
# Places around a VPL where its surface is looked for, at this share of its disk's radius: half of the area is nearer.
PLACES = wp.constant(8)
MIDDLE = wp.constant(0.70710678)
# Fewer than these are not believed.
LEAST_COVERED = wp.constant(3)
# A VPL answers for points within this many of its radii, stretched along the normals (gpu.grid).
REACH = wp.constant(2.0)
# Levels beside each other are held alike (gpu.grid), so every second one is searched.
LEVEL_STEP = wp.constant(2)
SEARCHES = 5

nearest = nearest_search(1, cells=1)


@wp.func
def straight_distance(p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> float:
    """Distance of two points, whatever their surfaces' normals are."""
    return wp.length(q - p)


neighbours = nearest_search(NEIGHBOURS, straight_distance)


@wp.struct
class RadiosityMap:
    """VPLs that know the radiosity around them. radiosity (vpl,) [W/m²]; `vpls.spacing` are radii of the estimates."""

    vpls: Representatives
    radiosity: wp.array[wp.vec3]


@wp.kernel
def first_radius_kernel(first: int, clusters: VplClusters, radius: wp.array[float]) -> None:
    """One thread a cluster: about how far its members' last neighbours are; 0 where the cluster has no extent."""
    cluster = first + wp.tid()
    begin = clusters.starts[cluster]
    end = clusters.starts[cluster + 1]
    area = clusters.disks[cluster].area / float(end - begin)
    for member in range(begin, end):
        radius[member] = wp.sqrt(float(wp.static(NEIGHBOURS)) * area / PI)


@wp.kernel
def radiosity_kernel(first: int, vpls: Representatives, flux: wp.array[wp.vec3], radius: wp.array[float],
                     radiosity: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a VPL: flux per area of the disk that its neighbours fill, and that disk's radius."""
    vpl = first + wp.tid()
    radius[vpl] = 0.0
    radiosity[vpl] = wp.vec3(0.0, 0.0, 0.0)
    if vpls.spacing[vpl] <= 0.0:
        return
    level = vpls.level[vpl]
    found = neighbours(vpls, vpls.position[vpl], vpls.normal[vpl], level, NORMAL_THRESHOLD)
    # Beyond a cell the search is not complete.
    disk = wp.min(found.distance[wp.static(NEIGHBOURS - 1)], 1.0 / cells_per_unit(level))
    if disk <= 0.0:
        return
    total = wp.vec3(0.0, 0.0, 0.0)
    for place in range(wp.static(NEIGHBOURS)):
        if found.distance[place] < disk:
            other = found.cluster[place]
            off = wp.dot(vpls.position[other] - vpls.position[vpl], vpls.normal[vpl])
            if wp.abs(off) < PLANE_SHARE * disk:
                total += flux[other]
    radius[vpl] = disk
    radiosity[vpl] = total / (PI * disk * disk)


@wp.kernel
def coverage_kernel(first: int, scene: SceneData, vpls: Representatives, radius: wp.array[float],
                    covered: wp.array[int]) -> None:  # fmt: skip
    """One thread a place around a VPL, in the middle of its disk's area: 1 where its surface goes on, else 0.

    covered: (vpl, place), flattened. The surface ends at its edge, and where something stands on it.
    """
    index = first + wp.tid()
    vpl = index // PLACES
    covered[index] = 0
    normal = vpls.normal[vpl]
    disk = radius[vpl]
    turn = (float(index % PLACES) + float(hashed(wp.uint32(vpl))) * TO_UNIT) * (2.0 * PI / float(PLACES))
    frame = orthonormal(normal)
    direction = frame * wp.vec3(wp.cos(turn), wp.sin(turn), 0.0)
    height = PLANE_SHARE * disk
    origin = vpls.position[vpl] + normal * height
    way = MIDDLE * disk
    if disk <= 0.0 or occluded(scene, origin, direction, way):
        return
    hit = closest_hit(scene, origin + direction * way, -normal, 2.0 * height)
    if hit.face != NO_HIT and wp.abs(wp.dot(triangle_normal(scene, hit.face), normal)) > NORMAL_THRESHOLD:
        covered[index] = 1


@wp.kernel
def cover_kernel(first: int, covered: wp.array[int], radiosity: wp.array[wp.vec3]) -> None:
    """One thread a VPL: its radiosity is that of the part of its disk that is surface."""
    vpl = first + wp.tid()
    number = int(0)
    for place in range(PLACES):
        number += covered[vpl * PLACES + place]
    radiosity[vpl] = radiosity[vpl] * float(PLACES) / float(wp.max(number, LEAST_COVERED))


def radiosity_map(resident: ResidentScene, scene: SceneData, clusters: VplClusters) -> RadiosityMap:
    """The radiosity at the members of `clusters`, of which there is one or more, on the surfaces of `scene`."""
    members, device = clusters.members, resident.device
    grid = Grid(members.count, device)
    vpls = grid.data
    vpls.position, vpls.normal = members.position, members.normal
    launch(first_radius_kernel, clusters.count, [clusters, vpls.spacing], device)
    grid.build()
    radius = wp.zeros(members.count, dtype=float, device=device)
    result = RadiosityMap()
    result.radiosity = wp.zeros(members.count, dtype=wp.vec3, device=device)
    launch(radiosity_kernel, members.count, [vpls, members.flux, radius, result.radiosity], device)
    covered = wp.zeros(int(PLACES) * members.count, dtype=int, device=device)
    launch(coverage_kernel, int(PLACES) * members.count, [scene, vpls, radius, covered], device)
    launch(cover_kernel, members.count, [covered, result.radiosity], device)
    vpls.spacing = radius
    grid.build()
    result.vpls = vpls
    return result


@wp.func
def vpl_around(lit: RadiosityMap, position: wp.vec3, normal: wp.vec3, scale: float) -> int:
    """The VPL that answers for a surface point, −1 where none is near; those much denser than `scale` are not found."""
    vpl = int(-1)
    level = level_of(scale)
    for _search in range(wp.static(SEARCHES)):
        if vpl < 0:
            found = nearest(lit.vpls, position, normal, level, NORMAL_THRESHOLD)
            if found.cluster[0] >= 0 and found.distance[0] < REACH * lit.vpls.spacing[found.cluster[0]]:
                vpl = found.cluster[0]
            level += LEVEL_STEP
    return vpl

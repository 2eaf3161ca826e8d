"""VPL clusters as disk lights: what represents each cluster's VPLs in shading. Step 2 of the 2022 paper."""

import numpy as np
import warp as wp

from gpu.device import allocate, launch
from gpu.disk import Disk, disk_at, disk_of
from gpu.grid import FAR_AWAY
from gpu.kmeans import KMeans
from gpu.resident import ResidentScene
from gpu.sampling import PI
from gpu.scene.types import Ints
from gpu.sums import Sum, added
from gpu.vpl import Vpls, allocate_vpls, gather_kernel, vpl_points

ITERATIONS = 10
# Bounds are this much wider than what they hold, against rounding.
WIDER = wp.constant(1.0001)
# Unit space: rounding moves points of one plane apart by this much.
IN_PLANE = wp.constant(1.0e-6)
# Fewer members than that may lie close together by chance, or be one, and tell nothing of the area they stand for.
FEW_MEMBERS = wp.constant(4)
# Area of clusters of many members over that of the disk that reaches the nearest other: 0.41 to 0.5 in their median.
NEAREST_SHARE = wp.constant(0.45)
# VPLs in a twig.
PER_TWIG = wp.constant(8)
# A group's clusters fill bytes of visibility bits; tables with an entry a group and SP cluster stay small.
LEAST_PER_GROUP = 8
MOST_GROUPS = 512


@wp.struct
class VplClusters:
    """Clusters of VPLs in the order of their seeds, so that neighbours on a surface lie side by side; none is empty.

    disks (cluster,): what stands for them, at a member each; cone: cosine of the widest angle between the
    representative's normal and a member's; extent: farthest member's distance; thickness: that along the normal.
    Cluster c's members are starts[c] … starts[c + 1] − 1 of `members`. Of these, each PER_TWIG that follow each other
    are a twig: disks twig_starts[c] … twig_starts[c + 1] − 1 of `twigs`.
    Each `per_group` clusters that are neighbours form a group, of which there are `groups`. centre, radius, axis,
    spread (group,): a sphere that holds all of its members, and a cone, given by its axis and its angle's cosine, that
    holds their normals.
    """

    count: int
    per_group: int
    groups: int
    disks: wp.array[Disk]
    cone: wp.array[float]
    extent: wp.array[float]
    thickness: wp.array[float]
    starts: wp.array[int]
    members: Vpls
    twig_starts: wp.array[int]
    twigs: wp.array[Disk]
    centre: wp.array[wp.vec3]
    radius: wp.array[float]
    axis: wp.array[wp.vec3]
    spread: wp.array[float]


@wp.func
def cluster_of(clusters: VplClusters, member: int) -> int:
    """The cluster that a member belongs to."""
    low = int(0)
    high = clusters.count - 1
    while low < high:
        middle = (low + high + 1) // 2
        if clusters.starts[middle] <= member:
            low = middle
        else:
            high = middle - 1
    return low


@wp.func
def neighbour_area(vpls: Vpls, medoids: wp.array[int], cluster: int) -> float:
    """The area that a cluster has by its distance to the nearest other that faces a like way; 0 if there is none.

    A disk of no area would light what is near without bound. The share is what clusters of many members have.
    """
    position = vpls.position[medoids[cluster]]
    normal = vpls.normal[medoids[cluster]]
    nearest = float(FAR_AWAY)
    for other in range(medoids.shape[0]):
        if other != cluster and wp.dot(normal, vpls.normal[medoids[other]]) > 0.0:
            nearest = wp.min(nearest, wp.length_sq(vpls.position[medoids[other]] - position))
    return wp.where(nearest < FAR_AWAY, NEAREST_SHARE * PI * nearest, 0.0)


@wp.kernel
def summarise_kernel(first: int, vpls: Vpls, medoids: wp.array[int], out: VplClusters) -> None:
    """One thread a cluster: the disk light that stands for its members. medoids (cluster,): indices of `vpls`."""
    cluster = first + wp.tid()
    centre = vpls.position[medoids[cluster]]
    normal = vpls.normal[medoids[cluster]]
    flux = Sum()
    mean = wp.vec3(0.0, 0.0, 0.0)
    square = float(0.0)
    total = float(0.0)
    cone = float(1.0)
    extent = float(0.0)
    thickness = float(0.0)
    for member in range(out.starts[cluster], out.starts[cluster + 1]):
        member_flux = out.members.flux[member]
        flux = added(flux, member_flux)
        weight = member_flux[0] + member_flux[1] + member_flux[2]
        offset = out.members.position[member] - centre
        mean += offset * weight
        square += wp.length_sq(offset) * weight
        total += weight
        cone = wp.min(cone, wp.dot(normal, out.members.normal[member]))
        extent = wp.max(extent, wp.length(offset))
        thickness = wp.max(thickness, wp.abs(wp.dot(offset, normal)))
    mean = mean / total
    variance = wp.max(square / total - wp.length_sq(mean), 0.0)
    area = 2.0 * PI * variance
    if out.starts[cluster + 1] - out.starts[cluster] < FEW_MEMBERS:
        area = wp.max(area, neighbour_area(vpls, medoids, cluster))
    out.disks[cluster] = disk_of(centre, normal, flux.total, area, variance, cone)
    out.cone[cluster] = cone
    out.extent[cluster] = extent
    out.thickness[cluster] = thickness


@wp.kernel
def twig_kernel(first: int, out: VplClusters) -> None:
    """One thread a cluster: the disks that stand for its twigs, each with its members' share of the cluster's area."""
    cluster = first + wp.tid()
    begin = out.starts[cluster]
    end = out.starts[cluster + 1]
    for twig in range(out.twig_starts[cluster], out.twig_starts[cluster + 1]):
        flux = wp.vec3(0.0, 0.0, 0.0)
        position = wp.vec3(0.0, 0.0, 0.0)
        normal = wp.vec3(0.0, 0.0, 0.0)
        total = float(0.0)
        last = wp.min(begin + PER_TWIG, end)
        for member in range(begin, last):
            member_flux = out.members.flux[member]
            weight = member_flux[0] + member_flux[1] + member_flux[2]
            flux += member_flux
            position += out.members.position[member] * weight
            normal += out.members.normal[member] * weight
            total += weight
        position = position / total
        normal = wp.normalize(normal)
        cone = float(1.0)
        square = float(0.0)
        for member in range(begin, last):
            member_flux = out.members.flux[member]
            weight = member_flux[0] + member_flux[1] + member_flux[2]
            square += wp.length_sq(out.members.position[member] - position) * weight
            cone = wp.min(cone, wp.dot(normal, out.members.normal[member]))
        area = out.disks[cluster].area * float(last - begin) / float(end - out.starts[cluster])
        out.twigs[twig] = disk_of(position, normal, flux, area, square / total, cone)
        begin = last


@wp.kernel
def bound_kernel(first: int, out: VplClusters) -> None:
    """One thread a group of clusters: the bounds of their members and of their normals."""
    group = first + wp.tid()
    begin = out.per_group * group
    end = wp.min(begin + out.per_group, out.count)
    centre = wp.vec3(0.0, 0.0, 0.0)
    axis = wp.vec3(0.0, 0.0, 0.0)
    for cluster in range(begin, end):
        centre += out.disks[cluster].position / float(end - begin)
        axis += out.disks[cluster].normal
    axis = wp.normalize(axis)
    radius = float(0.0)
    widest = float(0.0)
    for cluster in range(begin, end):
        radius = wp.max(radius, wp.length(out.disks[cluster].position - centre) + out.extent[cluster])
        off = wp.acos(wp.clamp(wp.dot(axis, out.disks[cluster].normal), -1.0, 1.0))
        widest = wp.max(widest, off + wp.acos(wp.clamp(out.cone[cluster], -1.0, 1.0)))
    out.centre[group] = centre
    out.radius[group] = radius * WIDER
    out.axis[group] = axis
    out.spread[group] = wp.cos(wp.min(widest * WIDER, PI))


@wp.func
def out_of_reach(position: wp.vec3, normal: wp.vec3, clusters: VplClusters, group: int) -> bool:
    """Whether no member of a group can light a point: all lie behind its surface, or it behind all of theirs."""
    way = position - clusters.centre[group]
    radius = clusters.radius[group]
    if wp.dot(way, normal) >= radius:
        return True
    distance = wp.length(way)
    across = wp.dot(way, clusters.axis[group])
    spread = clusters.spread[group]
    if across >= distance * spread or distance <= radius:
        return False
    # cos(θ − α), of the normal that is nearest to the direction of the point.
    beside = wp.sqrt(wp.max(distance * distance - across * across, 0.0))
    return across * spread + beside * wp.sqrt(wp.max(1.0 - spread * spread, 0.0)) + radius <= 0.0


@wp.func
def member_disk(clusters: VplClusters, member: int, area: float) -> Disk:
    """A VPL as a disk light of its own."""
    members = clusters.members
    return disk_of(members.position[member], members.normal[member], members.flux[member], area, 0.0, 1.0)


@wp.func
def is_behind(position: wp.vec3, normal: wp.vec3, clusters: VplClusters, cluster: int) -> bool:
    """Whether all members of a cluster lie in or behind the plane of a point's surface, as those of that surface do."""
    disk = disk_at(clusters.disks, cluster)
    alike = wp.dot(normal, disk.normal)
    height = wp.dot(disk.position - position, normal)
    height += clusters.extent[cluster] * wp.sqrt(wp.max(1.0 - alike * alike, 0.0))
    return height + clusters.thickness[cluster] * wp.abs(alike) <= IN_PLANE


def most_groups(count: int) -> int:
    """The most groups that up to `count` clusters form."""
    return min(MOST_GROUPS, -(-count // LEAST_PER_GROUP))


def set_groups(clusters: VplClusters, device: wp.Device) -> None:
    """Form groups of `clusters`, of which there is one or more, and fill in their bounds."""
    clusters.per_group = LEAST_PER_GROUP
    while clusters.per_group * MOST_GROUPS < clusters.count:
        clusters.per_group *= 2
    clusters.groups = -(-clusters.count // clusters.per_group)
    for name in ("centre", "axis"):
        setattr(clusters, name, wp.zeros(clusters.groups, dtype=wp.vec3, device=device))
    for name in ("radius", "spread"):
        setattr(clusters, name, wp.zeros(clusters.groups, dtype=float, device=device))
    launch(bound_kernel, clusters.groups, [clusters], device)


def set_twigs(clusters: VplClusters, starts: Ints, device: wp.Device) -> None:
    """Form twigs of the members of `clusters`, which begin at `starts` (cluster + 1,)."""
    twig_starts = np.append(0, np.cumsum(-(-np.diff(starts) // PER_TWIG)))
    clusters.twig_starts = wp.array(twig_starts, dtype=int, device=device)
    clusters.twigs = wp.zeros(int(twig_starts[-1]), dtype=Disk, device=device)
    launch(twig_kernel, clusters.count, [clusters], device)


def no_clusters() -> VplClusters:
    """None at all."""
    clusters = VplClusters()
    clusters.count = clusters.groups = 0  # ints, which the struct's own zeros are not
    return clusters


def cluster_vpls(resident: ResidentScene, vpls: Vpls, wanted: int, seed: int) -> VplClusters:
    """At most `wanted` clusters of `vpls`, by flux-weighted k-means on position and normal."""
    device = resident.device
    if vpls.count == 0:
        return no_clusters()
    kmeans = KMeans(vpls.count, min(wanted, vpls.count), device, exhaustive=True)
    kmeans.run(vpl_points(vpls, device), ITERATIONS, seed)
    starts = kmeans.groups.starts.numpy()
    used = np.flatnonzero(np.diff(starts))
    clusters: VplClusters = allocate(VplClusters, len(used), device)
    clusters.count = len(used)
    starts = np.append(starts[used], vpls.count).astype(np.int32)
    clusters.starts = wp.array(starts, dtype=int, device=device)
    clusters.members = allocate_vpls(vpls.count, device)
    launch(gather_kernel, vpls.count, [kmeans.groups.items, vpls, clusters.members], device)
    medoids = wp.array(kmeans.medoids.numpy()[used], dtype=int, device=device)
    launch(summarise_kernel, clusters.count, [vpls, medoids, clusters], device)
    set_twigs(clusters, starts, device)
    set_groups(clusters, device)
    return clusters


@wp.kernel
def single_kernel(first: int, clusters: VplClusters, singles: wp.array[Disk]) -> None:
    """One thread a cluster: makes each member a disk of its own with its share of the cluster's area."""
    cluster = first + wp.tid()
    begin = clusters.starts[cluster]
    end = clusters.starts[cluster + 1]
    area = clusters.disks[cluster].area / float(end - begin)
    for member in range(begin, end):
        singles[member] = member_disk(clusters, member, area)


def unclustered(resident: ResidentScene, clusters: VplClusters) -> VplClusters:
    """Every VPL of `clusters` as a disk light of its own: what `exact-vpl` shades, and the ablation of SPs alone."""
    device, members = resident.device, clusters.members
    if clusters.count == 0:
        return no_clusters()
    singles: VplClusters = allocate(VplClusters, members.count, device)
    singles.count = members.count
    singles.cone.fill_(1.0)
    singles.members = members
    launch(single_kernel, clusters.count, [clusters, singles.disks], device)
    starts = np.arange(members.count + 1, dtype=np.int32)
    singles.starts = wp.array(starts, dtype=int, device=device)
    set_twigs(singles, starts, device)
    set_groups(singles, device)
    return singles

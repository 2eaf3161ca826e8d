"""Makes the disk lights of VPL clusters. Step 2 of the 2022 paper, section 3.1."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY, PI
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import float_least, float_sum, vector_sum
from gpu.core.kahan import Sum, kahan_add
from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls
from gpu.scene.types import Ints
from gpu.vpl.disk_light import Disk, disk_of
from gpu.vpl.vpl_clusters import LEAST_PER_GROUP, MOST_GROUPS, PER_SUBCLUSTER, VplClusters, member_disk

# Bounds are this much wider than what they hold, against rounding.
WIDER = wp.constant(1.0001)


@wp.struct
@dataclass
class VplClusterParameters:
    """How VPLs are clustered.

    iterations: of k-means, which begins at means of neighbours in Morton order: more than four lead no further;
    few_members: fewer may lie close together by chance, or be one, and tell nothing of the area they stand for, which
    is then this `nearest_share` at least of the disk that reaches the nearest other cluster: clusters of many members
    have 0.41 to 0.5 of it in their median.
    """

    iterations: int = 4
    few_members: int = 4
    nearest_share: float = 0.45


VPL_CLUSTER_PARAMETERS: VplClusterParameters = parameters(VplClusterParameters)


@wp.kernel
def neighbour_area_kernel(first: int, vpls: Vpls, medoids: wp.array[int], starts: wp.array[int],
                          chosen: VplClusterParameters, lanes: int, areas: wp.array[float]) -> None:  # fmt: skip
    """`lanes` threads a cluster: the area that one of few members has by its distance to the nearest other that faces a
    like way, areas (cluster,); 0 if there is none.

    A disk of no area would light what is near without bound. medoids (cluster,), starts (cluster + 1,): of the
    members of each.
    """
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    if lane == 0:
        areas[cluster] = 0.0
    if medoids[cluster] < 0 or starts[cluster + 1] - starts[cluster] >= chosen.few_members:
        return
    position = vpls.position[medoids[cluster]]
    normal = vpls.normal[medoids[cluster]]
    nearest = float(FAR_AWAY)
    for other in range(lane, medoids.shape[0], lanes):
        medoid = medoids[other]
        if other == cluster or medoid < 0:
            continue
        if wp.dot(normal, vpls.normal[medoid]) > 0.0:
            nearest = wp.min(nearest, wp.length_sq(vpls.position[medoid] - position))
    nearest = float_least(nearest, lanes)
    if lane == 0 and nearest < FAR_AWAY:
        areas[cluster] = chosen.nearest_share * PI * nearest


@wp.kernel
def vpl_cluster_disk_kernel(first: int, vpls: Vpls, medoids: wp.array[int], least_areas: wp.array[float], lanes: int,
                            out: VplClusters) -> None:  # fmt: skip
    """`lanes` threads a cluster: the disk light that stands for its members, of which each has its flux's share of the
    area; but for its flux.

    least_areas (cluster,): that it has at least; medoids (cluster,): indices of `vpls`, −1 for a cluster without
    members, whose disk sends nothing anywhere.
    """
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    if medoids[cluster] < 0:
        if lane == 0:
            out.disks[cluster] = Disk()
            out.normal_cone_cos[cluster] = 1.0
            out.extent[cluster] = 0.0
            out.thickness[cluster] = 0.0
        return
    centre = vpls.position[medoids[cluster]]
    normal = vpls.normal[medoids[cluster]]
    flux = Sum()  # of what paths bring: the disk is the same when a light is dimmed
    mean = wp.vec3(0.0, 0.0, 0.0)
    square = float(0.0)
    normal_cone_cos = float(1.0)
    extent = float(0.0)
    thickness = float(0.0)
    begin = out.starts[cluster]
    end = out.starts[cluster + 1]
    number = float(end - begin)
    for member in range(begin + lane, end, lanes):
        flux = kahan_add(flux, out.path_flux[member])
        # By number: one VPL that carries most of the flux stands for a wide surface, not for a point.
        offset = out.members.position[member] - centre
        mean += offset / number
        square += wp.length_sq(offset) / number
        normal_cone_cos = wp.min(normal_cone_cos, wp.dot(normal, out.members.normal[member]))
        extent = wp.max(extent, wp.length(offset))
        thickness = wp.max(thickness, wp.abs(wp.dot(offset, normal)))
    total = vector_sum(flux.total, lanes)
    mean = vector_sum(mean, lanes)
    variance = wp.max(float_sum(square, lanes) - wp.length_sq(mean), 0.0)
    area = wp.max(2.0 * PI * variance, least_areas[cluster])
    for member in range(begin + lane, end, lanes):
        out.member_area[member] = area * brightness(out.path_flux[member]) / brightness(total)
    normal_cone_cos = float_least(normal_cone_cos, lanes)
    extent = -float_least(-extent, lanes)
    thickness = -float_least(-thickness, lanes)
    if lane != 0:
        return
    out.disks[cluster] = disk_of(centre, normal, wp.vec3(0.0, 0.0, 0.0), area, variance, normal_cone_cos)
    out.normal_cone_cos[cluster] = normal_cone_cos
    out.extent[cluster] = extent
    out.thickness[cluster] = thickness


@wp.kernel
def vpl_subcluster_disk_kernel(first: int, lanes: int, out: VplClusters) -> None:
    """`lanes` threads a cluster: the disks that stand for its subclusters, each with its members' area, but for their
    flux.
    """
    index = first + wp.tid()
    cluster = index // lanes
    end = out.starts[cluster + 1]
    own = out.subcluster_starts[cluster]
    for subcluster in range(own + index % lanes, out.subcluster_starts[cluster + 1], lanes):
        begin = out.starts[cluster] + PER_SUBCLUSTER * (subcluster - own)
        position = wp.vec3(0.0, 0.0, 0.0)
        normal = wp.vec3(0.0, 0.0, 0.0)
        total = float(0.0)
        last = wp.min(begin + PER_SUBCLUSTER, end)
        for member in range(begin, last):
            member_flux = out.path_flux[member]
            weight = member_flux[0] + member_flux[1] + member_flux[2]
            position += out.members.position[member] * weight
            normal += out.members.normal[member] * weight
            total += weight
        position = position / total
        normal = wp.normalize(normal)
        normal_cone_cos = float(1.0)
        square = float(0.0)
        for member in range(begin, last):
            member_flux = out.path_flux[member]
            weight = member_flux[0] + member_flux[1] + member_flux[2]
            square += wp.length_sq(out.members.position[member] - position) * weight
            normal_cone_cos = wp.min(normal_cone_cos, wp.dot(normal, out.members.normal[member]))
        area = float(0.0)
        for member in range(begin, last):
            area += out.member_area[member]
        disk = disk_of(position, normal, wp.vec3(0.0, 0.0, 0.0), area, square / total, normal_cone_cos)
        out.subclusters[subcluster] = disk


@wp.kernel
def member_flux_kernel(first: int, shares: wp.array[wp.vec3], out: VplClusters) -> None:
    """One thread a VPL: its flux, by what its light is of that which paths are drawn by: shares (light,)."""
    member = first + wp.tid()
    out.members.flux[member] = wp.cw_mul(out.path_flux[member], shares[out.members.light[member]])


@wp.kernel
def disk_flux_kernel(first: int, lanes: int, out: VplClusters) -> None:
    """`lanes` threads a cluster: the flux of its disk and of those of its subclusters, of their members."""
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    end = out.starts[cluster + 1]
    own = out.subcluster_starts[cluster]
    whole = Sum()
    for subcluster in range(own + lane, out.subcluster_starts[cluster + 1], lanes):
        begin = out.starts[cluster] + PER_SUBCLUSTER * (subcluster - own)
        flux = wp.vec3(0.0, 0.0, 0.0)
        last = wp.min(begin + PER_SUBCLUSTER, end)
        for member in range(begin, last):
            whole = kahan_add(whole, out.members.flux[member])
            flux += out.members.flux[member]
        out.subclusters[subcluster].flux = flux
    total = vector_sum(whole.total, lanes)
    if lane == 0:
        out.disks[cluster].flux = total


@wp.kernel
def vpl_group_bounds_kernel(first: int, out: VplClusters) -> None:
    """One thread a group of clusters: the bounds of their members and of their normals."""
    group = first + wp.tid()
    begin = out.per_group * group
    end = wp.min(begin + out.per_group, out.count)
    centre = wp.vec3(0.0, 0.0, 0.0)
    axis = wp.vec3(0.0, 0.0, 0.0)
    used = float(0.0)
    for cluster in range(begin, end):
        if out.starts[cluster + 1] > out.starts[cluster]:
            centre += out.disks[cluster].position
            axis += out.disks[cluster].normal
            used += 1.0
    centre = centre / wp.max(used, 1.0)
    axis = wp.normalize(axis)
    radius = float(0.0)
    widest = float(0.0)
    for cluster in range(begin, end):
        if out.starts[cluster + 1] == out.starts[cluster]:
            continue
        radius = wp.max(radius, wp.length(out.disks[cluster].position - centre) + out.extent[cluster])
        off = wp.acos(wp.clamp(wp.dot(axis, out.disks[cluster].normal), -1.0, 1.0))
        widest = wp.max(widest, off + wp.acos(wp.clamp(out.normal_cone_cos[cluster], -1.0, 1.0)))
    out.centre[group] = centre
    out.radius[group] = radius * WIDER
    out.axis[group] = axis
    out.axis_cone_cos[group] = wp.cos(wp.min(widest * WIDER, PI))


def form_groups(clusters: VplClusters, device: wp.Device) -> None:
    """Form groups of `clusters`, of which there is one or more; `bound_groups` fills in their bounds."""
    clusters.per_group = LEAST_PER_GROUP
    while clusters.per_group * MOST_GROUPS < clusters.count:
        clusters.per_group *= 2
    clusters.groups = -(-clusters.count // clusters.per_group)
    for name in ("centre", "axis"):
        setattr(clusters, name, wp.zeros(clusters.groups, dtype=wp.vec3, device=device))
    for name in ("radius", "axis_cone_cos"):
        setattr(clusters, name, wp.zeros(clusters.groups, dtype=float, device=device))


def bound_groups(clusters: VplClusters, device: wp.Device) -> None:
    """Fill in the bounds of the groups of `clusters`."""
    launch(vpl_group_bounds_kernel, clusters.groups, [clusters], device)


def set_subclusters(clusters: VplClusters, starts: Ints, device: wp.Device) -> None:
    """Form subclusters of the members of `clusters`, which begin at `starts` (cluster + 1,)."""
    subcluster_starts = np.append(0, np.cumsum(-(-np.diff(starts) // PER_SUBCLUSTER)))
    clusters.subcluster_starts = wp.array(subcluster_starts, dtype=int, device=device)
    clusters.subclusters = wp.zeros(int(subcluster_starts[-1]), dtype=Disk, device=device)
    launch(vpl_subcluster_disk_kernel, clusters.count, [1, clusters], device)
    launch(disk_flux_kernel, clusters.count, [1, clusters], device)


def no_clusters() -> VplClusters:
    """None at all."""
    clusters = VplClusters()
    clusters.count = clusters.groups = 0  # ints, which the struct's own zeros are not
    return clusters


@wp.kernel
def vpl_singles_kernel(first: int, clusters: VplClusters, singles: wp.array[Disk]) -> None:
    """One thread a member: makes it a disk of its own."""
    member = first + wp.tid()
    singles[member] = member_disk(clusters, member)


def unclustered(device_scene: DeviceScene, clusters: VplClusters) -> VplClusters:
    """Every VPL of `clusters` as a disk light of its own: what `exact-vpl` shades, and the ablation of SPs alone."""
    device, members = device_scene.device, clusters.members
    if clusters.count == 0:
        return no_clusters()
    singles: VplClusters = allocate(VplClusters, members.count, device)
    singles.count = members.count
    singles.normal_cone_cos.fill_(1.0)
    singles.members, singles.path_flux = members, clusters.path_flux
    launch(vpl_singles_kernel, members.count, [clusters, singles.disks], device)
    singles.member_area = clusters.member_area
    starts = np.arange(members.count + 1, dtype=np.int32)
    singles.starts = wp.array(starts, dtype=int, device=device)
    set_subclusters(singles, starts, device)
    form_groups(singles, device)
    bound_groups(singles, device)
    return singles

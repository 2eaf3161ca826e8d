"""VPL clusters as disk lights: what represents each cluster's VPLs in shading. Step 2 of the 2022 paper."""

import numpy as np
import warp as wp

from gpu.device import allocate, launch
from gpu.kmeans import KMeans
from gpu.resident import ResidentScene
from gpu.sampling import PI
from gpu.sums import Sum, added
from gpu.vpl import Vpls, allocate_vpls, gather_kernel, vpl_points

ITERATIONS = 10


@wp.struct
class VplClusters:
    """Clusters of VPLs in the order of their seeds, so that neighbours on a surface lie side by side; none is empty.

    position, normal: (cluster,) of the representative, a member; flux: summed over members [W], per channel;
    area: of the disk that spreads as the members do, unit space; cone: cosine of the widest angle between the
    representative's normal and a member's. Cluster c's members are starts[c] … starts[c + 1] − 1 of `members`.
    """

    count: int
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    flux: wp.array[wp.vec3]
    area: wp.array[float]
    cone: wp.array[float]
    starts: wp.array[int]
    members: Vpls


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
    for member in range(out.starts[cluster], out.starts[cluster + 1]):
        member_flux = out.members.flux[member]
        flux = added(flux, member_flux)
        weight = member_flux[0] + member_flux[1] + member_flux[2]
        offset = out.members.position[member] - centre
        mean += offset * weight
        square += wp.length_sq(offset) * weight
        total += weight
        cone = wp.min(cone, wp.dot(normal, out.members.normal[member]))
    mean = mean / total
    out.position[cluster] = centre
    out.normal[cluster] = normal
    out.flux[cluster] = flux.total
    # A uniform disk of radius R has the variance R²/2 about its centre.
    out.area[cluster] = 2.0 * PI * wp.max(square / total - wp.length_sq(mean), 0.0)
    out.cone[cluster] = cone


def cluster_vpls(resident: ResidentScene, vpls: Vpls, wanted: int, seed: int) -> VplClusters:
    """At most `wanted` clusters of `vpls`, by flux-weighted k-means on position and normal."""
    device = resident.device
    clusters = VplClusters()
    clusters.count = 0  # an int, which the struct's own zero is not
    if vpls.count == 0:
        return clusters
    kmeans = KMeans(vpls.count, min(wanted, vpls.count), device, exhaustive=True)
    kmeans.run(vpl_points(vpls, device), ITERATIONS, seed)
    starts = kmeans.groups.starts.numpy()
    used = np.flatnonzero(np.diff(starts))
    clusters = allocate(VplClusters, len(used), device)
    clusters.count = len(used)
    clusters.starts = wp.array(np.append(starts[used], vpls.count), dtype=int, device=device)
    clusters.members = allocate_vpls(vpls.count, device)
    launch(gather_kernel, vpls.count, [kmeans.groups.items, vpls, clusters.members], device)
    medoids = wp.array(kmeans.medoids.numpy()[used], dtype=int, device=device)
    launch(summarise_kernel, clusters.count, [vpls, medoids, clusters], device)
    return clusters


@wp.kernel
def member_area_kernel(first: int, clusters: VplClusters, area: wp.array[float]) -> None:
    """One thread a cluster: shares its disk's area among its members. area: (member,)."""
    cluster = first + wp.tid()
    begin = clusters.starts[cluster]
    end = clusters.starts[cluster + 1]
    for member in range(begin, end):
        area[member] = clusters.area[cluster] / float(end - begin)


def unclustered(resident: ResidentScene, clusters: VplClusters) -> VplClusters:
    """Every VPL of `clusters` as a disk light of its own: what `exact-vpl` shades, and the ablation of SPs alone."""
    members = clusters.members
    singles = VplClusters()
    singles.count = 0
    if clusters.count == 0:
        return singles
    singles.count = members.count
    singles.position, singles.normal, singles.flux = members.position, members.normal, members.flux
    singles.area = wp.zeros(members.count, dtype=float, device=resident.device)
    singles.cone = wp.full(members.count, 1.0, dtype=float, device=resident.device)
    singles.starts = wp.array(np.arange(members.count + 1), dtype=int, device=resident.device)
    singles.members = members
    launch(member_area_kernel, clusters.count, [clusters, singles.area], resident.device)
    return singles

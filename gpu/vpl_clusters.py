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
# A uniform disk of radius R has the deviation R/2 along any line in it, as an even spread of ± R·√3/2; R² = A/π.
EVEN_RADIUS_SQUARED = wp.constant(0.75 / PI)
# The deviation of members' normals over the widest of them.
CONE_SHARE = wp.constant(0.5)
# Bounds are this much wider than what they hold, against rounding.
WIDER = wp.constant(1.0001)


@wp.struct
class VplClusters:
    """Clusters of VPLs in the order of their seeds, so that neighbours on a surface lie side by side; none is empty.

    position, normal: (cluster,) of the representative, a member; flux: summed over members [W], per channel;
    area: of the disk that spreads as the members do, unit space; cone: cosine of the widest angle between the
    representative's normal and a member's; extent: farthest member's distance; reach: ± what members are spread by
    along any line in the disk; turn: ± what their normals' cosines are. Cluster c's members are starts[c] …
    starts[c + 1] − 1 of `members`.
    centre, radius, axis, spread (word,): a sphere that holds all members of 32 neighbouring clusters, and a cone, given
    by its axis and its angle's cosine, that holds their normals.
    """

    count: int
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    flux: wp.array[wp.vec3]
    area: wp.array[float]
    cone: wp.array[float]
    extent: wp.array[float]
    reach: wp.array[float]
    turn: wp.array[float]
    centre: wp.array[wp.vec3]
    radius: wp.array[float]
    axis: wp.array[wp.vec3]
    spread: wp.array[float]
    starts: wp.array[int]
    members: Vpls


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
    mean = mean / total
    out.position[cluster] = centre
    out.normal[cluster] = normal
    out.flux[cluster] = flux.total
    # A uniform disk of radius R has the variance R²/2 about its centre.
    out.area[cluster] = 2.0 * PI * wp.max(square / total - wp.length_sq(mean), 0.0)
    out.cone[cluster] = cone
    out.extent[cluster] = extent
    out.reach[cluster] = wp.sqrt(EVEN_RADIUS_SQUARED * out.area[cluster])
    out.turn[cluster] = CONE_SHARE * wp.sqrt(wp.max(1.0 - cone * cone, 0.0))


@wp.kernel
def bound_kernel(first: int, out: VplClusters) -> None:
    """One thread a word of 32 clusters: the bounds of their members and of their normals."""
    word = first + wp.tid()
    begin = 32 * word
    end = wp.min(begin + 32, out.count)
    centre = wp.vec3(0.0, 0.0, 0.0)
    axis = wp.vec3(0.0, 0.0, 0.0)
    for cluster in range(begin, end):
        centre += out.position[cluster] / float(end - begin)
        axis += out.normal[cluster]
    axis = wp.normalize(axis)
    radius = float(0.0)
    widest = float(0.0)
    for cluster in range(begin, end):
        radius = wp.max(radius, wp.length(out.position[cluster] - centre) + out.extent[cluster])
        off = wp.acos(wp.clamp(wp.dot(axis, out.normal[cluster]), -1.0, 1.0))
        widest = wp.max(widest, off + wp.acos(wp.clamp(out.cone[cluster], -1.0, 1.0)))
    out.centre[word] = centre
    out.radius[word] = radius * WIDER
    out.axis[word] = axis
    out.spread[word] = wp.cos(wp.min(widest * WIDER, PI))


def bound(clusters: VplClusters, device: wp.Device) -> None:
    """Fill in the bounds of the words of `clusters`, of which there is one or more."""
    words = -(-clusters.count // 32)
    for name in ("centre", "axis"):
        setattr(clusters, name, wp.zeros(words, dtype=wp.vec3, device=device))
    for name in ("radius", "spread"):
        setattr(clusters, name, wp.zeros(words, dtype=float, device=device))
    launch(bound_kernel, words, [clusters], device)


@wp.func
def out_of_reach(position: wp.vec3, normal: wp.vec3, clusters: VplClusters, word: int) -> bool:
    """Whether no member of 32 clusters can light a point: all lie behind its surface, or it behind all of theirs."""
    way = position - clusters.centre[word]
    radius = clusters.radius[word]
    if wp.dot(way, normal) >= radius:
        return True
    distance = wp.length(way)
    across = wp.dot(way, clusters.axis[word])
    spread = clusters.spread[word]
    if across >= distance * spread or distance <= radius:
        return False
    # cos(θ − α), of the normal that is nearest to the direction of the point.
    beside = wp.sqrt(wp.max(distance * distance - across * across, 0.0))
    return across * spread + beside * wp.sqrt(wp.max(1.0 - spread * spread, 0.0)) + radius <= 0.0


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
    bound(clusters, device)
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
    for name in ("extent", "reach", "turn"):
        setattr(singles, name, wp.zeros(members.count, dtype=float, device=resident.device))
    singles.starts = wp.array(np.arange(members.count + 1), dtype=int, device=resident.device)
    singles.members = members
    launch(member_area_kernel, clusters.count, [clusters, singles.area], resident.device)
    bound(singles, resident.device)
    return singles

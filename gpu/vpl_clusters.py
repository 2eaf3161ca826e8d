"""VPL clusters as disk lights: what represents each cluster's VPLs in shading. Step 2 of the 2022 paper."""

import warp as wp

from gpu.device import allocate, launch
from gpu.kmeans import KMeans
from gpu.resident import ResidentScene
from gpu.sampling import PI
from gpu.vpl import Vpls, vpl_points

ITERATIONS = 10


@wp.struct
class VplClusters:
    """Clusters of VPLs in Morton order, without empty ones.

    position, normal: (cluster,) of the representative, a member; flux: summed over members [W], per channel;
    area: of the disk that spreads as the members do, unit space; cone: cosine of the widest angle between the
    representative's normal and a member's.
    """

    count: int
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    flux: wp.array[wp.vec3]
    area: wp.array[float]
    cone: wp.array[float]


def allocate_vpl_clusters(count: int, device: wp.Device) -> VplClusters:
    """Room for `count` clusters."""
    clusters: VplClusters = allocate(VplClusters, count, device)
    clusters.count = count
    return clusters


@wp.kernel
def summarise_kernel(first: int, vpls: Vpls, members: wp.array[int], starts: wp.array[int], medoids: wp.array[int],
                     used: wp.array[int], out: VplClusters) -> None:  # fmt: skip
    """One thread a used cluster: the disk light that stands for its members."""
    index = first + wp.tid()
    cluster = used[index]
    medoid = medoids[cluster]
    centre = vpls.position[medoid]
    normal = vpls.normal[medoid]
    flux = wp.vec3(0.0, 0.0, 0.0)
    mean = wp.vec3(0.0, 0.0, 0.0)
    square = float(0.0)
    total = float(0.0)
    cone = float(1.0)
    for place in range(starts[cluster], starts[cluster + 1]):
        vpl = members[place]
        flux += vpls.flux[vpl]
        weight = vpls.flux[vpl][0] + vpls.flux[vpl][1] + vpls.flux[vpl][2]
        offset = vpls.position[vpl] - centre
        mean += offset * weight
        square += wp.length_sq(offset) * weight
        total += weight
        cone = wp.min(cone, wp.dot(normal, vpls.normal[vpl]))
    mean = mean / total
    out.position[index] = centre
    out.normal[index] = normal
    out.flux[index] = flux
    # A uniform disk of radius R has the variance R²/2 about its centre.
    out.area[index] = 2.0 * PI * wp.max(square / total - wp.length_sq(mean), 0.0)
    out.cone[index] = cone


def cluster_vpls(resident: ResidentScene, vpls: Vpls, wanted: int, seed: int) -> VplClusters:
    """At most `wanted` clusters of `vpls`, by flux-weighted k-means on position and normal."""
    device = resident.device
    if vpls.count == 0:
        return allocate_vpl_clusters(0, device)
    kmeans = KMeans(vpls.count, min(wanted, vpls.count), device, exhaustive=True)
    kmeans.run(vpl_points(vpls, device), ITERATIONS, seed)
    medoids = kmeans.medoids.numpy()
    used = wp.array((medoids >= 0).nonzero()[0], dtype=wp.int32, device=device)
    clusters = allocate_vpl_clusters(len(used), device)
    groups = kmeans.groups
    inputs = [vpls, groups.items, groups.starts, kmeans.medoids, used, clusters]
    launch(summarise_kernel, len(used), inputs, device)
    return clusters


def singleton_clusters(resident: ResidentScene, vpls: Vpls) -> VplClusters:
    """Every VPL as a cluster of its own: what `exact-vpl` shades, and the ablation that clusters SPs only."""
    device = resident.device
    clusters = allocate_vpl_clusters(vpls.count, device)
    clusters.position, clusters.normal, clusters.flux = vpls.position, vpls.normal, vpls.flux
    clusters.cone.fill_(1.0)
    return clusters

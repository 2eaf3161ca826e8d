"""Clusters of reflective shadow maps as disk lights, in arrays that stay: section 5 of the 2012 paper.

Each disk's centre is the medoid and its area that of its members' spread, as for all VPL clusters (gpu.vpl.build).
Eq. 2 as printed misses 1/π in its far limit; disks send A·cosθ·cosθ′/(π·d² + A) (gpu.vpl.form_factor).
"""

import warp as wp

from gpu.core.device import allocate, launch
from gpu.core.radix_sort import running_total
from gpu.lights.light_paths import Vpls, allocate_vpls, gather_vpls_kernel
from gpu.vpl.build import (
    VPL_CLUSTER_PARAMETERS,
    VplClusterParameters,
    bound_groups,
    form_groups,
    vpl_cluster_disk_kernel,
    vpl_subcluster_disk_kernel,
)
from gpu.vpl.disk_light import Disk
from gpu.vpl.shadow_map_clusters import ShadowMapClustering
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters


@wp.kernel
def subcluster_count_kernel(first: int, starts: wp.array[int], counts: wp.array[int]) -> None:
    """One thread a cluster: how many subclusters its members are."""
    cluster = first + wp.tid()
    counts[cluster] = (starts[cluster + 1] - starts[cluster] + PER_SUBCLUSTER - 1) // PER_SUBCLUSTER


class MapLights:
    """The lights of a clustering: `vpls`, a cluster each, with room for all pixels of its maps as members.

    Members from starts[count] on are pixels without light.
    """

    def __init__(self, clustering: ShadowMapClustering, chosen: VplClusterParameters = VPL_CLUSTER_PARAMETERS) -> None:
        self._clustering, self._chosen, self.device = clustering, chosen, clustering.device
        count, pixels = clustering.count, clustering.groups.capacity
        self.vpls: VplClusters = allocate(VplClusters, count, self.device)
        self.vpls.count, self.vpls.starts = count, clustering.groups.starts
        self.vpls.members = allocate_vpls(pixels, self.device)
        self.vpls.member_area = wp.zeros(pixels, dtype=float, device=self.device)
        self.vpls.subcluster_starts = wp.zeros(count + 1, dtype=int, device=self.device)
        most = -(-pixels // int(PER_SUBCLUSTER)) + count
        self.vpls.subclusters = wp.zeros(most, dtype=Disk, device=self.device)
        self._counts = wp.zeros(count, dtype=int, device=self.device)
        form_groups(self.vpls, self.device)

    def run(self, pixels: Vpls) -> None:
        """Make the lights of the clusters that `pixels`, those of the maps, have just been put into."""
        vpls, clustering, device = self.vpls, self._clustering, self.device
        launch(gather_vpls_kernel, pixels.count, [clustering.groups.items, pixels, vpls.members], device)
        launch(vpl_cluster_disk_kernel, vpls.count, [pixels, clustering.medoids, self._chosen, vpls], device)
        launch(subcluster_count_kernel, vpls.count, [vpls.starts, self._counts], device)
        running_total(self._counts, vpls.subcluster_starts[1:])
        launch(vpl_subcluster_disk_kernel, vpls.count, [vpls], device)
        bound_groups(vpls, device)

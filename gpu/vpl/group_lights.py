"""Groups of VPLs as disk lights, in arrays that stay: step 2 of the 2022 paper, section 5 of the 2012 paper.

Each disk's centre is the medoid and its area that of its members' spread (gpu.vpl.build). Eq. 2 of the 2012 paper as
printed misses 1/π in its far limit; disks send A·cosθ·cosθ′/(π·d² + A) (gpu.vpl.form_factor).
"""

import warp as wp

from gpu.core.bucket_sort import Buckets
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import lanes_of
from gpu.core.radix_sort import Groups, running_total
from gpu.lights.light_paths import Vpls, allocate_vpls, gather_vpls_kernel
from gpu.vpl.build import (
    VPL_CLUSTER_PARAMETERS,
    VplClusterParameters,
    bound_groups,
    form_groups,
    neighbour_area_kernel,
    vpl_cluster_disk_kernel,
    vpl_subcluster_disk_kernel,
)
from gpu.vpl.disk_light import Disk
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters


@wp.kernel
def subcluster_count_kernel(first: int, starts: wp.array[int], counts: wp.array[int]) -> None:
    """One thread a cluster: how many subclusters its members are."""
    cluster = first + wp.tid()
    counts[cluster] = (starts[cluster + 1] - starts[cluster] + PER_SUBCLUSTER - 1) // PER_SUBCLUSTER


class GroupLights:
    """The lights of up to `capacity` VPLs in `count` groups: `vpls`, a cluster each; all is allocated once.

    Members from starts[count] on are of no group.
    """

    def __init__(
        self, capacity: int, count: int, device: wp.Device, chosen: VplClusterParameters = VPL_CLUSTER_PARAMETERS
    ) -> None:
        self.chosen, self.device = chosen, device
        self.vpls: VplClusters = allocate(VplClusters, count, device)
        self.vpls.count, self.vpls.starts = count, wp.zeros(count + 1, dtype=int, device=device)
        self.vpls.members = allocate_vpls(capacity, device)
        self.vpls.member_area = wp.zeros(capacity, dtype=float, device=device)
        self.vpls.subcluster_starts = wp.zeros(count + 1, dtype=int, device=device)
        most = -(-capacity // int(PER_SUBCLUSTER)) + count
        self.vpls.subclusters = wp.zeros(most, dtype=Disk, device=device)
        self._counts = wp.zeros(count, dtype=int, device=device)
        self._least_areas = wp.zeros(count, dtype=float, device=device)
        form_groups(self.vpls, device)

    def run(self, vpls: Vpls, groups: Groups | Buckets, medoids: wp.array) -> None:
        """Make the lights of the `groups` that `vpls` have been put into; medoids (group,): as of a KMeans."""
        lights, device = self.vpls, self.device
        wp.copy(lights.starts, groups.starts)
        launch(gather_vpls_kernel, len(lights.member_area), [groups.items, vpls, lights.members], device)
        lanes, least = lanes_of(device, few=True), self._least_areas
        inputs = [vpls, medoids, lights.starts, self.chosen, lanes, least]
        launch(neighbour_area_kernel, lanes * lights.count, inputs, device)
        launch(vpl_cluster_disk_kernel, lights.count, [vpls, medoids, least, lights], device)
        launch(subcluster_count_kernel, lights.count, [lights.starts, self._counts], device)
        running_total(self._counts, lights.subcluster_starts[1:])
        launch(vpl_subcluster_disk_kernel, lights.count, [lights], device)
        bound_groups(lights, device)

"""Groups of VPLs as disk lights, in arrays that stay: step 2 of the 2022 paper, section 5 of the 2012 paper.

Each disk's centre is the medoid and its area that of its members' spread (gpu.vpl.build). Eq. 2 of the 2012 paper as
printed misses 1/π in its far limit; disks send A·cosθ·cosθ′/(π·d² + A) (gpu.vpl.form_factor).
"""

import warp as wp

from gpu.core.bucket_sort import Buckets
from gpu.core.device import allocate, duplicate, launch
from gpu.core.intrinsics import lanes_of
from gpu.core.radix_sort import Groups, running_total
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.lights.path_ends import gather_vpls_kernel
from gpu.vpl.build import (
    VPL_CLUSTER_PARAMETERS,
    VplClusterParameters,
    bound_groups,
    disk_flux_kernel,
    form_groups,
    member_flux_kernel,
    neighbour_area_kernel,
    vpl_cluster_disk_kernel,
    vpl_subcluster_disk_kernel,
)
from gpu.vpl.disk_light import Disk
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters


@wp.kernel
def subcluster_count_kernel(first: int, starts: wp.array[int], counts: wp.array[int]) -> None:
    """One thread a cluster: how many subclusters its members are; starts (cluster + 1,), counts (cluster,)."""
    cluster = first + wp.tid()
    counts[cluster] = (starts[cluster + 1] - starts[cluster] + PER_SUBCLUSTER - 1) // PER_SUBCLUSTER


class GroupLights:
    """The lights of up to `capacity` VPLs in `count` groups: `vpls`, a cluster each; all is allocated once.

    shares (light,): what lights are of what paths are drawn by (gpu.scene.lighting.path_light), if not all of it.
    Members from starts[count] on are of no group.
    """

    def __init__(
        self,
        capacity: int,
        count: int,
        device: wp.Device,
        chosen: VplClusterParameters = VPL_CLUSTER_PARAMETERS,
        shares: wp.array | None = None,
    ) -> None:
        self.chosen, self.device, self._shares = chosen, device, shares
        self.vpls: VplClusters = allocate(VplClusters, count, device)
        self.vpls.count, self.vpls.starts = count, wp.zeros(count + 1, dtype=int, device=device)
        self.vpls.members = allocate_vpls(capacity, device)
        self.vpls.path_flux = self.vpls.members.flux if shares is None else wp.zeros_like(self.vpls.members.flux)
        self._gathered: Vpls = duplicate(Vpls, self.vpls.members)
        self._gathered.flux = self.vpls.path_flux
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
        launch(gather_vpls_kernel, len(lights.member_area), [groups.items, vpls, self._gathered], device)
        lanes, least = lanes_of(device, few=True), self._least_areas
        inputs = [vpls, medoids, lights.starts, self.chosen, lanes, least]
        launch(neighbour_area_kernel, lanes * lights.count, inputs, device)
        launch(vpl_cluster_disk_kernel, lanes * lights.count, [vpls, medoids, least, lanes, lights], device)
        launch(subcluster_count_kernel, lights.count, [lights.starts, self._counts], device)
        running_total(self._counts, lights.subcluster_starts[1:])
        launch(vpl_subcluster_disk_kernel, lanes * lights.count, [lanes, lights], device)
        bound_groups(lights, device)
        self.relight()

    def relight(self) -> None:
        """Have their flux follow the `shares`: all else is as it was."""
        if self._shares is not None:
            launch(member_flux_kernel, len(self.vpls.member_area), [self._shares, self.vpls], self.device)
        lanes = lanes_of(self.device, few=True)
        launch(disk_flux_kernel, lanes * self.vpls.count, [lanes, self.vpls], self.device)

"""Clusters VPLs and makes their disk lights. Steps 1 and 2 of the 2022 paper, section 3.1."""

import warp as wp

from gpu.clustering.kmeans import KMeans
from gpu.clustering.points import Points
from gpu.core.device import launch
from gpu.lights.light_paths import Vpls
from gpu.vpl.group_lights import GroupLights


@wp.kernel
def vpl_weight_kernel(first: int, vpls: Vpls, weight: wp.array[float], spacing: wp.array[float]) -> None:
    """One thread a VPL: its weight in clustering, the mean of its flux's channels. Spacing is not used there."""
    index = first + wp.tid()
    flux = vpls.flux[index]
    weight[index] = (flux[0] + flux[1] + flux[2]) / 3.0
    spacing[index] = 1.0


class VplClustering:
    """Clusters of the first `count` (1,) of `vpls`, `most` of them where there are as many VPLs, by flux-weighted
    k-means on position and normal; its arrays are allocated once.
    """

    def __init__(self, vpls: Vpls, count: wp.array, most: int, device: wp.Device) -> None:
        self._vpls, self._kmeans = vpls, KMeans(vpls.count, most, device, exhaustive=True)
        self._points = Points()
        self._points.position, self._points.normal, self._points.count = vpls.position, vpls.normal, count
        self._points.weight = wp.zeros(vpls.count, dtype=float, device=device)
        self._points.spacing = wp.zeros(vpls.count, dtype=float, device=device)

    def run(self, lights: GroupLights, seed: int) -> None:
        """Cluster the VPLs as they are now, and make the `lights` of the clusters, without leaving the device."""
        vpls, points, kmeans = self._vpls, self._points, self._kmeans
        launch(vpl_weight_kernel, vpls.count, [vpls, points.weight, points.spacing], kmeans.device)
        kmeans.run(points, lights.chosen.iterations, seed)
        lights.run(vpls, kmeans.groups, kmeans.medoids)

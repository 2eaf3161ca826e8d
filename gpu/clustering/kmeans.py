"""K-means of surface points on position and normal: Algorithm 1 of the 2022 paper, for SPs and for VPLs alike.

Differences from the paper, each for a fault seen on real scenes: a cluster is represented by its medoid, since the mean
lies inside or behind geometry; sums run over sorted members instead of atomics, so that the same seed gives the same
bits; a cluster that lost its members starts again at a random point; distances along the normal count more
(gpu.clustering.grid).
"""

from copy import copy
from functools import cache

import warp as wp

from gpu.clustering.cluster_bounds import ClusterRunBounds, ClusterRuns, nearest_in_runs
from gpu.clustering.grid import Grid, Representatives, level_of, separation
from gpu.clustering.nearest import nearest_search
from gpu.clustering.points import Points
from gpu.core.bucket_sort import Buckets
from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.intrinsics import float_sum, lanes_of, place_of_least, vector_sum
from gpu.core.radix_sort import Groups
from gpu.sampling.sobol import hashed


@wp.kernel
def kmeans_seed_kernel(first: int, points: Points, wanted: wp.array[int], seed: int, clusters: Representatives) -> None:
    """One thread a cluster: starts one of `wanted` (1,) at a point of each of equal runs of the points' order."""
    cluster = first + wp.tid()
    count = points.count[0]
    used = wp.min(wanted[0], count)
    clusters.spacing[cluster] = 0.0
    if cluster >= used:
        return
    begin = int(wp.int64(cluster) * wp.int64(count) / wp.int64(used))
    end = int(wp.int64(cluster + 1) * wp.int64(count) / wp.int64(used))
    pick = hashed(wp.uint32(cluster) ^ hashed(wp.uint32(seed)))
    point = begin + int(pick % wp.uint32(wp.max(end - begin, 1)))
    clusters.position[cluster] = points.position[point]
    clusters.normal[cluster] = points.normal[point]
    clusters.spacing[cluster] = points.spacing[point]


@cache
def kmeans_assign_kernel(metric: wp.Function) -> wp.Kernel:
    """The kernel for clusters that are near by `metric`."""
    nearest = nearest_search(1, metric)

    @wp.kernel(module="unique")
    def kmeans_assign_kernel(
        first: int, points: Points, clusters: Representatives, none: int, keys: wp.array[int]
    ) -> None:
        """One thread a point: keys[point] becomes its nearest cluster, or `none` where none is near."""
        point = first + wp.tid()
        keys[point] = none
        if point >= points.count[0]:
            return
        level = level_of(clusters.chosen, points.spacing[point])
        found = nearest(clusters, points.position[point], points.normal[point], level)
        if found.cluster[0] >= 0:
            keys[point] = found.cluster[0]

    return kmeans_assign_kernel


@wp.kernel
def kmeans_guess_kernel(first: int, points: Points, wanted: wp.array[int], none: int, owner: wp.array[int],
                        keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: owner and keys (point,) become the cluster that starts in its run of the points' order.

    wanted (1,): how many clusters there are; none: the key of what is no point.
    """
    point = first + wp.tid()
    count = points.count[0]
    keys[point] = none
    if point < count:
        owner[point] = int(wp.int64(point) * wp.int64(wp.min(wanted[0], count)) / wp.int64(count))
        keys[point] = owner[point]


@wp.kernel
def kmeans_assign_to_any_kernel(first: int, points: Points, clusters: Representatives, none: int,
                                runs: ClusterRunBounds, lanes: int, owner: wp.array[int],
                                keys: wp.array[int]) -> None:  # fmt: skip
    """`lanes` threads a point: keys[point] becomes the nearest of all clusters, of those with a like normal if any.

    owner (point,): what that was before; none: the key of what is no point.
    """
    index = first + wp.tid()
    point = index // lanes
    lane = index % lanes
    if point >= points.count[0]:
        if lane == 0:
            keys[point] = none
        return
    position = points.position[point]
    found = nearest_in_runs(clusters, runs, position, points.normal[point], owner[point], lane, lanes)
    if lane == 0:
        owner[point] = found
        keys[point] = found


@wp.kernel
def kmeans_mean_kernel(first: int, points: Points, members: wp.array[int], starts: wp.array[int], wanted: wp.array[int],
                       seed: int, lanes: int, clusters: Representatives) -> None:  # fmt: skip
    """`lanes` threads a cluster: move it to its members' weighted mean; without any it starts again at a random
    point. members, starts (cluster + 1,): of each; wanted (1,): how many clusters there are.
    """
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    count = points.count[0]
    if cluster >= wp.min(wanted[0], count):
        return
    position = wp.vec3(0.0, 0.0, 0.0)
    normal = wp.vec3(0.0, 0.0, 0.0)
    spacing = float(0.0)
    total = float(0.0)
    for place in range(starts[cluster] + lane, starts[cluster + 1], lanes):
        point = members[place]
        weight = points.weight[point]
        position += points.position[point] * weight
        normal += points.normal[point] * weight
        spacing += points.spacing[point] * weight
        total += weight
    position = vector_sum(position, lanes)
    normal = vector_sum(normal, lanes)
    spacing = float_sum(spacing, lanes)
    total = float_sum(total, lanes)
    if lane != 0:
        return
    if total > 0.0 and wp.length_sq(normal) > 0.0:
        clusters.position[cluster] = position / total
        clusters.normal[cluster] = wp.normalize(normal)
        clusters.spacing[cluster] = spacing / total
        return
    point = int(hashed(wp.uint32(cluster) ^ hashed(wp.uint32(seed))) % wp.uint32(count))
    clusters.position[cluster] = points.position[point]
    clusters.normal[cluster] = points.normal[point]
    clusters.spacing[cluster] = points.spacing[point]


@cache
def kmeans_medoid_kernel(metric: wp.Function) -> wp.Kernel:
    """The kernel for members that are near by `metric`."""

    @wp.kernel(module="unique")
    def kmeans_medoid_kernel(first: int, points: Points, members: wp.array[int], starts: wp.array[int], lanes: int,
                             clusters: Representatives, medoids: wp.array[int]) -> None:  # fmt: skip
        """`lanes` threads a cluster: its representative becomes the member nearest its mean; without members it is
        dropped.
        """
        index = first + wp.tid()
        cluster = index // lanes
        lane = index % lanes
        best_place = int(-1)
        best_distance = float(FAR_AWAY)
        position = clusters.position[cluster]
        normal = clusters.normal[cluster]
        for place in range(starts[cluster] + lane, starts[cluster + 1], lanes):
            point = members[place]
            distance = metric(clusters.chosen, points.position[point], points.normal[point], position, normal)
            if distance < best_distance:
                best_distance = distance
                best_place = place
        best_place = place_of_least(best_distance, best_place, lanes)
        if lane != 0:
            return
        best = int(-1)
        if best_place >= 0:
            best = members[best_place]
        medoids[cluster] = best
        if best >= 0:
            clusters.position[cluster] = points.position[best]
            clusters.normal[cluster] = points.normal[best]
            clusters.spacing[cluster] = points.spacing[best]
        else:
            clusters.spacing[cluster] = 0.0

    return kmeans_medoid_kernel


class KMeans:
    """K-means of up to `capacity` points into `wanted` (1,) clusters, at most `most`; arrays are allocated once.

    After `run`: `grid` holds the representatives (and room for `extra` more), `medoids` (cluster,) the point that each
    is, −1 for a dropped one and those beyond `wanted`, and `groups` the members that it is the medoid of. `exhaustive`
    finds every point the nearest of all clusters, so that none is left out, and once more after the last means: for
    VPLs, whose light would be lost and whose spacing is not known beforehand, and of which a cluster may have any
    number. SPs are not searched again: they look for clusters by themselves. `uneven`: clusters may have any number of
    members, too; metric: by which they are near, unless `exhaustive`.
    """

    def __init__(
        self,
        capacity: int,
        most: int,
        device: wp.Device,
        *,
        extra: int = 0,
        exhaustive: bool = False,
        uneven: bool = False,
        metric: wp.Function = separation,
    ) -> None:
        self.most, self.device = most, device
        self.wanted = wp.full(1, most, dtype=int, device=device)
        self._exhaustive, self._metric = exhaustive, metric
        self.grid = Grid(most + extra, device)
        self.groups = (Groups if exhaustive or uneven else Buckets)(capacity, most, device)
        self.medoids = wp.zeros(most + extra, dtype=int, device=device)
        if exhaustive:
            self._runs = ClusterRuns(most, device)
            self._owner = wp.zeros(capacity, dtype=int, device=device)

    def over(self, grid: Grid, wanted: wp.array) -> "KMeans":
        """K-means into `wanted` (1,) clusters of another grid; both share all else, so they run one after the other."""
        other = copy(self)
        other.grid, other.wanted = grid, wanted
        return other

    def run(self, points: Points, iterations: int, seed: int) -> None:
        """Cluster `points`: `iterations` rounds, one at least, of assignment and update, then the medoids.

        Where the search is exhaustive, clusters start at the means of runs of the points' order.
        """
        launch(kmeans_seed_kernel, self.most, [points, self.wanted, seed, self.grid.data], self.device)
        if self._exhaustive:
            self._guess(points)
            self.groups.sort()
            self._update(points, seed)
        self.refine(points, iterations, seed)

    def refine(self, points: Points, iterations: int, seed: int) -> None:
        """As `run`, of clusters that are in `grid` already."""
        clusters, groups = self.grid.data, self.groups
        lanes = lanes_of(self.device, few=True)
        if self._exhaustive:
            self._guess(points)
        for iteration in range(iterations):
            self._assign(points)
            self._update(points, seed + iteration + 1)
        if self._exhaustive:
            self._assign(points)
        inputs = [points, groups.items, groups.starts, lanes, clusters, self.medoids]
        launch(kmeans_medoid_kernel(self._metric), lanes * self.most, inputs, self.device)

    def _guess(self, points: Points) -> None:
        inputs = [points, self.wanted, self.most, self._owner, self.groups.keys]
        launch(kmeans_guess_kernel, self.groups.capacity, inputs, self.device)

    def _update(self, points: Points, seed: int) -> None:
        groups, lanes = self.groups, lanes_of(self.device, few=True)
        inputs = [points, groups.items, groups.starts, self.wanted, seed, lanes, self.grid.data]
        launch(kmeans_mean_kernel, lanes * self.most, inputs, self.device)

    def _assign(self, points: Points) -> None:
        clusters, keys, capacity = self.grid.data, self.groups.keys, self.groups.capacity
        if self._exhaustive:
            self._runs.bound(clusters)
            lanes = lanes_of(self.device, few=True)
            inputs = [points, clusters, self.most, self._runs.bounds, lanes, self._owner, keys]
            launch(kmeans_assign_to_any_kernel, lanes * capacity, inputs, self.device)
        else:
            self.grid.build()
            launch(kmeans_assign_kernel(self._metric), capacity, [points, clusters, self.most, keys], self.device)
        self.groups.sort()

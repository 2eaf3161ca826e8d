"""Clusters of shading points whose centres are where incident light is sampled: 2009 paper, section 3.2."""

from functools import cache

import warp as wp

from gpu.clustering.grid import ClusteringParameters, Representatives, separation
from gpu.clustering.kmeans import KMeans
from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sampling.sobol import hashed
from gpu.sp.variation_tree import (
    SEEDING_PARAMETERS,
    SeedingParameters,
    VariationTree,
    allocate_variation_tree,
    build_variation_tree,
    seeded_run,
)


@cache
def illumination_change(position_weight: float) -> wp.Function:
    """The metric of Eq. 2 over α = `position_weight`, its distance stretched along the normals: what is on another
    shelf is not near.
    """

    @wp.func
    def illumination_change(
        chosen: ClusteringParameters, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3
    ) -> float:
        bend = wp.sqrt(wp.max(2.0 - 2.0 * wp.dot(p_normal, q_normal), 0.0))
        return separation(chosen, p, p_normal, q, q_normal) + bend / wp.static(position_weight)

    return illumination_change


@wp.struct
class ShadingClusters:
    """The clusters' centres, which are SPs: position, normal, geometric_normal (cluster,); spacing (cluster,): the
    distance to neighbours, 0 for a cluster that is not in use.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    spacing: wp.array[float]


@wp.kernel
def listed_points_kernel(first: int, gbuffer: GBuffer, listed: PointList, out: Points) -> None:
    """One thread an SP: what clustering knows of it."""
    sp = first + wp.tid()
    if sp == 0:
        out.count[0] = listed.count[0]
    if sp < listed.count[0]:
        pixel = listed.pixels[sp]
        out.position[sp] = gbuffer.position[pixel]
        out.normal[sp] = gbuffer.normal[pixel]
        out.weight[sp] = 1.0


@wp.kernel
def run_spacing_kernel(first: int, gbuffer: GBuffer, listed: PointList, chosen: SeedingParameters, tree: VariationTree,
                       seeds: int, random: wp.array[int], out: Points) -> None:  # fmt: skip
    """One thread an SP: how far apart seeds are around it, by how many SPs share one."""
    sp = first + wp.tid()
    if sp >= out.count[0]:
        return
    run = seeded_run(chosen, out, tree, wp.min(seeds, out.count[0]), -1, sp, random[0])
    out.spacing[sp] = gbuffer.spacing[listed.pixels[sp]] * wp.sqrt(float(wp.max(run.end - run.begin, 1)))


@wp.kernel
def variation_seed_kernel(first: int, points: Points, chosen: SeedingParameters, tree: VariationTree,
                          random: wp.array[int], clusters: Representatives) -> None:  # fmt: skip
    """One thread a cluster: starts it at a random SP of its run."""
    cluster = first + wp.tid()
    seeds = wp.min(clusters.spacing.shape[0], points.count[0])
    clusters.spacing[cluster] = 0.0
    if cluster >= seeds:
        return
    run = seeded_run(chosen, points, tree, seeds, cluster, 0, random[0])
    if run.end > run.begin:
        pick = hashed(wp.uint32(cluster) ^ hashed(wp.uint32(random[0])))
        point = run.begin + int(pick % wp.uint32(run.end - run.begin))
        clusters.position[cluster] = points.position[point]
        clusters.normal[cluster] = points.normal[point]
        clusters.spacing[cluster] = points.spacing[point]


@wp.kernel
def centre_kernel(first: int, gbuffer: GBuffer, listed: PointList, medoids: wp.array[int],
                  clusters: ShadingClusters) -> None:  # fmt: skip
    """One thread a cluster: what rays from its centre need."""
    cluster = first + wp.tid()
    if clusters.spacing[cluster] > 0.0:
        clusters.geometric_normal[cluster] = gbuffer.geometric_normal[listed.pixels[medoids[cluster]]]


class ShadingClustering:
    """Makes at most `most` clusters of the SPs of a frame; arrays are allocated once.

    `grid` has the centres, `clusters` (ShadingClusters) what rays need of them, `points` the SPs with their spacing.
    """

    def __init__(self, listed: ListedPoints, most: int, chosen: SeedingParameters = SEEDING_PARAMETERS) -> None:
        device = self.device = listed.pixels.device
        self._listed, self._chosen, self.most = listed, chosen, min(most, listed.capacity)
        self.points: Points = allocate(Points, listed.capacity, device)
        self.points.count = wp.zeros(1, dtype=int, device=device)
        self._tree = allocate_variation_tree(listed.capacity, device)
        metric = illumination_change(float(chosen.position_weight))
        self._kmeans = KMeans(listed.capacity, self.most, device, uneven=True, metric=metric)
        self.grid = self._kmeans.grid
        self.clusters: ShadingClusters = allocate(ShadingClusters, self.most, device)
        data = self.grid.data
        self.clusters.position, self.clusters.normal, self.clusters.spacing = data.position, data.normal, data.spacing

    def run(self, gbuffer: GBuffer, random: wp.array) -> None:
        """Seed clusters where the geometry varies, refine them by k-means; random (1,): the frame's seed."""
        points, chosen, tree, most = self.points, self._chosen, self._tree, self.most
        capacity, device = self._listed.capacity, self.device
        launch(listed_points_kernel, capacity, [gbuffer, self._listed.points, points], device)
        build_variation_tree(points, tree)
        inputs = [gbuffer, self._listed.points, chosen, tree, most, random, points]
        launch(run_spacing_kernel, capacity, inputs, device)
        launch(variation_seed_kernel, most, [points, chosen, tree, random, self.grid.data], device)
        self._kmeans.refine(points, int(chosen.iterations), 0)
        self.grid.build()
        inputs = [gbuffer, self._listed.points, self._kmeans.medoids, self.clusters]
        launch(centre_kernel, most, inputs, device)

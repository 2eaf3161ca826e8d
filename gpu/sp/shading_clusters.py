"""Clusters of shading points whose centres are where incident light is sampled: 2009 paper, section 3.2."""

from functools import cache

import warp as wp

from gpu.clustering.grid import ClusteringParameters, Representatives, separation
from gpu.clustering.kmeans import KMeans
from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.gbuffer.gbuffer import GBuffer, apparent_position
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sampling.sobol import hashed
from gpu.sp.centres import KeptCentres, ShadingClusters
from gpu.sp.kept_centres import CentreKeeping
from gpu.sp.variation_tree import (
    SEEDING_PARAMETERS,
    SeedingParameters,
    VariationTree,
    allocate_variation_tree,
    build_variation_tree,
    seeded_run,
)

# A pixel sees more of a surface along which it looks; of what is seen along its whole length, next to nothing.
MIN_COSINE = wp.constant(0.1)


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
                       seeds: int, random: wp.array[int], out: Points,
                       pixel_spacing: wp.array[float]) -> None:  # fmt: skip
    """One thread an SP: how far apart seeds are around it, by how many SPs share one.

    pixel_spacing (pixel,): the same by pixel.
    """
    sp = first + wp.tid()
    if sp >= out.count[0]:
        return
    run = seeded_run(chosen, out, tree, wp.min(seeds, out.count[0]), -1, sp, random[0])
    pixel = listed.pixels[sp]
    cosine = wp.max(wp.dot(gbuffer.geometric_normal[pixel], gbuffer.to_camera[pixel]), MIN_COSINE)
    spacing = gbuffer.spacing[pixel] * wp.sqrt(float(wp.max(run.end - run.begin, 1)) / cosine)
    out.spacing[sp] = spacing
    pixel_spacing[pixel] = spacing


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
    """One thread a cluster: what rays from its centre need. medoids (cluster,): the SPs that the centres are."""
    cluster = first + wp.tid()
    if clusters.spacing[cluster] > 0.0:
        pixel = listed.pixels[medoids[cluster]]
        clusters.geometric_normal[cluster] = gbuffer.geometric_normal[pixel]
        clusters.apparent[cluster] = apparent_position(gbuffer, pixel)


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
        seeds = listed, self.points, self._tree, chosen
        self._keeping = CentreKeeping(*seeds, self.grid, self.clusters)

    def run(self, gbuffer: GBuffer, random: wp.array, kept: "KeptCentres | None" = None) -> None:
        """Seed clusters where the geometry varies, refine them by k-means; random (1,): the frame's seed.

        kept: what the next frame may go on with.
        """
        points, chosen, tree, most, device = self.points, self._chosen, self._tree, self.most, self.device
        self._spread(gbuffer, random)
        launch(variation_seed_kernel, most, [points, chosen, tree, random, self.grid.data], device)
        self._kmeans.refine(points, int(chosen.iterations), 0)
        self.grid.build()
        inputs = [gbuffer, self._listed.points, self._kmeans.medoids, self.clusters]
        launch(centre_kernel, most, inputs, device)
        if kept is not None:
            self._keeping.begin(kept)

    def go_on(self, gbuffer: GBuffer, random: wp.array, kept: KeptCentres, camera: wp.array,
              size: tuple[int, int]) -> None:  # fmt: skip
        """In place of `run`: clusters about the centres that the frame before has `kept`, and new ones where these do
        not serve; camera (1,): CameraData of `gbuffer`, a picture of `size`.
        """
        self._spread(gbuffer, random)
        self._keeping.run(gbuffer, random, kept, camera, size)

    def _spread(self, gbuffer: GBuffer, random: wp.array) -> None:
        """List the SPs, and tell how far apart seeds are around them."""
        points, tree, capacity = self.points, self._tree, self._listed.capacity
        launch(listed_points_kernel, capacity, [gbuffer, self._listed.points, points], self.device)
        build_variation_tree(points, tree)
        inputs = [gbuffer, self._listed.points, self._chosen, tree, self.most, random, points]
        launch(run_spacing_kernel, capacity, [*inputs, self._keeping.pixel_spacing], self.device)

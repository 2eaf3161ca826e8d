"""Final gather: light that reaches the centres of shading clusters, by many rays each (2009 paper, section 3.3)."""

from functools import cache
from typing import Any, Protocol

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import allocate, launch
from gpu.device_scene.bsdf import even_reflectance
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import closest_hit, offset_origin
from gpu.device_scene.surface import surface_at
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.sp.centres import ShadingClusters

WARP = 32  # threads that go together on a GPU


@wp.struct
class Gathered:
    """What rays find. radiance (cluster · rays,) [W/m²/sr] and nearness (cluster · rays,): one over the distance, 0 for
    a ray that meets nothing, of each ray; irradiance (cluster,) [W/m²]; least_distance (cluster,): length of the
    shortest ray, unit space.
    """

    radiance: wp.array[wp.vec3]
    nearness: wp.array[float]
    irradiance: wp.array[wp.vec3]
    least_distance: wp.array[float]


@wp.func
def gather_direction(clusters: ShadingClusters, order: wp.array[int], seeds: wp.array[int], cluster: int,
                     place: int) -> wp.vec3:  # fmt: skip
    """Direction of the ray at a place of the `order` of a cluster's, with density cosθ/π; seeds: one element."""
    point = sobol_pair(order[place], 0, pixel_seed(cluster, seeds[0]))
    return cosine_direction(clusters.normal[cluster], point.y, point.x)


@cache
def gather_ray_kernel(illumination: wp.Function, data: Any, texels: bool) -> wp.Kernel:
    """The kernel that reads illumination(scene, data, position, normal), irradiance, where rays end."""

    @wp.kernel(module="unique")
    def gather_ray_kernel(first: int, scene: SceneData, clusters: ShadingClusters, lit: data, order: wp.array[int],
                          seeds: wp.array[int], out: Gathered) -> None:  # fmt: skip
        """One thread a ray, those of a cluster in `order`: the light that it finds. seeds: one element."""
        index = first + wp.tid()
        rays = order.shape[0]
        cluster = index // rays
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        out.radiance[index] = wp.vec3(0.0, 0.0, 0.0)
        out.nearness[index] = 0.0
        if clusters.spacing[cluster] <= 0.0:
            return
        normal = clusters.geometric_normal[cluster]
        direction = gather_direction(clusters, order, seeds, cluster, index % rays)
        if wp.dot(direction, normal) <= 0.0:
            return
        hit = closest_hit(scene, offset_origin(clusters.position[cluster], normal, direction), direction, RAY_LENGTH)
        if hit.face == NO_HIT:
            return
        surface = surface_at(scene, hit, direction)
        found = illumination(scene, lit, surface.position, surface.geometric_normal)
        out.radiance[index] = wp.cw_mul(even_reflectance(surface, -direction), found) / PI
        out.nearness[index] = 1.0 / wp.max(hit.t, 1.0e-6)

    return gather_ray_kernel


@wp.kernel
def gather_sum_kernel(first: int, rays: int, out: Gathered) -> None:
    """One thread a cluster: the means of its rays, and the shortest."""
    cluster = first + wp.tid()
    total = wp.vec3(0.0, 0.0, 0.0)
    nearest = float(1.0e-6)
    for ray in range(cluster * rays, (cluster + 1) * rays):
        total += out.radiance[ray]
        nearest = wp.max(nearest, out.nearness[ray])
    out.irradiance[cluster] = total * (PI / float(rays))
    out.least_distance[cluster] = 1.0 / nearest


class Illumination(Protocol):
    """What rays read where they end: lookup(scene, lit, position, normal), irradiance [W/m²]; lit: of Warp struct
    `data`.
    """

    lookup: wp.Function
    data: Any
    lit: Any


def coherent_order(rays: int) -> list[int]:
    """Numbers of a Sobol sequence's points so that as many as threads of a warp follow each other from one slice of the
    first dimension, here the azimuth: they are those with the same remainder, and rays one way read the same nodes.
    """
    slices = 1 << max((rays // WARP).bit_length() - 1, 0)
    return sorted(range(rays), key=lambda number: (number % slices, number))


class FinalGather:
    """`rays` rays from the centre of each of `clusters`, which read `light`; `gathered` after `run`.

    order (ray,): which of a Sobol sequence's points a cluster's rays are.
    """

    def __init__(self, clusters: ShadingClusters, rays: int, light: Illumination) -> None:
        self._clusters, self._rays, self._light = clusters, rays, light
        self.order = wp.array(coherent_order(rays), dtype=int, device=clusters.spacing.device)
        self.device, self._count = clusters.spacing.device, len(clusters.spacing)
        self.gathered: Gathered = allocate(Gathered, self._count, self.device)
        self.gathered.radiance = wp.zeros(rays * self._count, dtype=wp.vec3, device=self.device)
        self.gathered.nearness = wp.zeros(rays * self._count, dtype=float, device=self.device)

    def run(self, scene: SceneData, seed: wp.array, features: SceneFeatures) -> None:
        """Gather what the rays see; seed (1,): of their directions."""
        kernel = gather_ray_kernel(self._light.lookup, self._light.data, features.texels)
        inputs = [scene, self._clusters, self._light.lit, self.order, seed, self.gathered]
        launch(kernel, self._count * self._rays, inputs, self.device)
        launch(gather_sum_kernel, self._count, [self._rays, self.gathered], self.device)

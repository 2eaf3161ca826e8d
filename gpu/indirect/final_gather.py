"""Final gather: light that reaches the centres of shading clusters, by many rays each (2009 paper, section 3.3)."""

from itertools import pairwise
from typing import Any

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, allocate, launch
from gpu.core.intrinsics import float_least, lanes_of, vector_sum
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.indirect.bright_photons import BrightPhotons, allocate_bright, find_bright, ray_share
from gpu.indirect.gather_rays import (
    RayEnds,
    coherent_order,
    gather_direction,
    gather_ray_kernel,
    gather_tint,
    list_unknown,
)
from gpu.indirect.guided_rays import GuidedRays, allocate_guided, trace_guided
from gpu.indirect.illumination import Illumination
from gpu.indirect.onward_paths import ONWARD_PARAMETERS, onward, onward_kernel
from gpu.lights.light_table import LightTable
from gpu.sp.centres import ShadingClusters


@wp.struct
class Gathered:
    """What rays find. radiance (cluster · rays,) [W/m²/sr] of each, over how often the cosine draws it; guided: of
    those towards bright photons; irradiance (cluster,) [W/m²]; least_distance (cluster,): length of the shortest ray,
    unit space, RAY_LENGTH where none meets anything.
    """

    radiance: wp.array[wp.vec3]
    guided: GuidedRays
    irradiance: wp.array[wp.vec3]
    least_distance: wp.array[float]


@made_for(*LOOK)
def read_light_kernel(features: SceneFeatures, lookup: wp.Function, data: Any) -> wp.Kernel:
    """The kernel for scenes of these `features` that reads where rays end; lookup, data: as of
    gpu.indirect.illumination.Illumination.
    """
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def read_light_kernel(first: int, scene: SceneData, clusters: ShadingClusters, lit: data, bright: BrightPhotons,
                          order: wp.array[int], seeds: wp.array[int], ends: RayEnds,
                          radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
        """One thread a ray: its `radiance` (cluster · rays,), or that nothing is known of it. order, seeds: as of
        gather_direction.
        """
        index = first + wp.tid()
        rays = order.shape[0]
        scene = specialise(scene)
        radiance[index] = wp.vec3(0.0, 0.0, 0.0)
        ends.unknown[index] = 0
        hit = ends.hits[index]
        if hit.face == NO_HIT:
            return
        direction = gather_direction(clusters, order, seeds, index // rays, index % rays)
        surface = met_at(scene, hit, direction)
        estimate = lookup(lit, surface.position, surface.geometric_normal)
        if estimate.known:
            cluster = index // rays
            way = surface.position - clusters.position[cluster]
            normal = clusters.normal[cluster]
            ratio = float(bright.guided) / float(bright.rays)
            share = ray_share(bright, estimate.irradiance, way, normal, surface.geometric_normal, ratio)
            light = wp.cw_mul(even_reflectance(surface, -direction), estimate.irradiance) / PI
            radiance[index] = light * share
            if scene.part_glass:
                tint = gather_tint(scene, clusters, hit, direction, cluster)
                radiance[index] = wp.cw_mul(radiance[index], tint)
        else:
            ends.unknown[index] = 1

    return read_light_kernel


@wp.kernel
def shortest_ray_kernel(first: int, lanes: int, rays: int, ends: RayEnds, out: Gathered) -> None:
    """`lanes` threads a cluster: the shortest of its rays."""
    index = first + wp.tid()
    cluster = index // lanes
    shortest = float(RAY_LENGTH)
    for ray in range(cluster * rays + index % lanes, (cluster + 1) * rays, lanes):
        if ends.hits[ray].face != NO_HIT:
            shortest = wp.min(shortest, ends.hits[ray].t)
    shortest = float_least(shortest, lanes)
    if index % lanes == 0:
        out.least_distance[cluster] = shortest


@wp.kernel
def gather_sum_kernel(first: int, lanes: int, rays: int, guided: int, out: Gathered) -> None:
    """`lanes` threads a cluster: the mean of its `rays`, to which the `guided` ones add."""
    index = first + wp.tid()
    cluster = index // lanes
    total = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(cluster * rays + index % lanes, (cluster + 1) * rays, lanes):
        total += out.radiance[ray]
    for ray in range(cluster * guided + index % lanes, (cluster + 1) * guided, lanes):
        total += out.guided.radiance[ray]
    total = vector_sum(total, lanes)
    if index % lanes == 0:
        out.irradiance[cluster] = total * (PI / float(rays))


class FinalGather:
    """`rays` rays from the centre of each of `clusters`, which read `light`, and where it tells nothing follow paths of
    at most `bounces` to the emitters of `table`; `gathered` after `trace`, of which the shortest are known, and `read`.

    order (ray,): which of a Sobol sequence's points a cluster's rays are.
    """

    def __init__(
        self, clusters: ShadingClusters, rays: int, light: Illumination, table: LightTable, bounces: int
    ) -> None:
        self._clusters, self._rays, self._light = clusters, rays, light
        parts = pairwise((0, 1, int(ONWARD_PARAMETERS.vertices)))
        self._bright = allocate_bright(light, rays)
        self._parts = [onward(table, self._bright, bounces, begin, end) for begin, end in parts]
        self.order = wp.array(coherent_order(rays), dtype=int, device=clusters.spacing.device)
        self.device, self._count = clusters.spacing.device, len(clusters.spacing)
        self.gathered: Gathered = allocate(Gathered, self._count, self.device)
        self.gathered.radiance = wp.zeros(rays * self._count, dtype=wp.vec3, device=self.device)
        self.gathered.guided = allocate_guided(self._bright.guided * self._count, self.device)
        self.ends: RayEnds = allocate(RayEnds, rays * self._count, self.device)

    def trace(self, scene: SceneData, seed: wp.array, features: SceneFeatures) -> None:
        """Find where the rays end, for which no light need be known; seed (1,): of their directions."""
        inputs = [scene, self._clusters, self.order, seed, self.ends]
        launch(gather_ray_kernel(features), self._count * self._rays, inputs, self.device)
        lanes = lanes_of(self.device, few=True)
        inputs = [lanes, self._rays, self.ends, self.gathered]
        launch(shortest_ray_kernel, lanes * self._count, inputs, self.device)

    def read(self, scene: SceneData, seed: wp.array, features: SceneFeatures) -> None:
        """Gather what the rays see that were traced by this `seed`."""
        light, ends, gathered, count = self._light, self.ends, self.gathered, self._count * self._rays
        rays = [self._clusters, self.order, seed, ends]
        read = read_light_kernel(features, light.lookup, light.data)
        find_bright(light, self._bright)
        inputs = [scene, self._clusters, light.lit, self._bright, self.order, seed, ends, gathered.radiance]
        launch(read, count, inputs, self.device)
        trace_guided(scene, self._clusters, light, self._bright, seed, features, gathered.guided)
        goes_on = onward_kernel(features, light.lookup, light.data)
        for part in self._parts:
            list_unknown(ends)
            launch(goes_on, count, [scene, part, light.lit, *rays, gathered.radiance], self.device)
        lanes = lanes_of(self.device, few=True)
        launch(gather_sum_kernel, lanes * self._count, [lanes, self._rays, self._bright.guided, gathered], self.device)

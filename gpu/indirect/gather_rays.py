"""Rays from the centres of shading clusters, and where they end (2009 paper, section 3.3).

They are traced before anything is read where they end: what does both needs so many registers that few rays are under
way at once.
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, launch
from gpu.core.radix_sort import running_total
from gpu.device_scene.data import NO_HIT, Hit, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.sampling.sobol import pixel_seed, sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.sp.centres import ShadingClusters

WARP = 32  # threads that go together on a GPU


@wp.struct
class RayEnds:
    """Where rays end. hits (cluster · rays,); unknown (cluster · rays,): 1 for one that meets a surface of whose light
    nothing is known, else 0; totals (cluster · rays,): the running sum of that; listed (cluster · rays,): as many as
    the last total, which ones they are.
    """

    hits: wp.array[Hit]
    unknown: wp.array[int]
    totals: wp.array[int]
    listed: wp.array[int]


def coherent_order(rays: int) -> list[int]:
    """Numbers of a Sobol sequence's points so that as many as threads of a warp follow each other from one slice of the
    first dimension, here the azimuth: they are those with the same remainder, and rays one way read the same nodes.
    """
    slices = 1 << max((rays // WARP).bit_length() - 1, 0)
    return sorted(range(rays), key=lambda number: (number % slices, number))


@wp.func
def gather_direction(clusters: ShadingClusters, order: wp.array[int], seeds: wp.array[int], cluster: int,
                     place: int) -> wp.vec3:  # fmt: skip
    """Direction of the ray at a place of the `order` of a cluster's, with density cosθ/π; seeds: one element."""
    point = sobol_pair(order[place], 0, pixel_seed(cluster, seeds[0]))
    return cosine_direction(clusters.normal[cluster], point.y, point.x)


@wp.func
def gather_tint(scene: SceneData, clusters: ShadingClusters, hit: Hit, direction: wp.vec3, cluster: int) -> wp.vec3:
    """How part glass tints what a ray of a cluster's along unit `direction` has `hit`."""
    origin = offset_origin(clusters.position[cluster], clusters.geometric_normal[cluster], direction)
    return crossed_tint(scene, origin, direction, hit.t, False)


@made_for(*LOOK)
def gather_ray_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def gather_ray_kernel(first: int, scene: SceneData, clusters: ShadingClusters, order: wp.array[int],
                          seeds: wp.array[int], ends: RayEnds) -> None:  # fmt: skip
        """One thread a ray, those of a cluster in `order`: where it ends. seeds: one element."""
        index = first + wp.tid()
        rays = order.shape[0]
        cluster = index // rays
        scene = specialise(scene)
        hit = Hit()
        hit.face = NO_HIT
        if clusters.spacing[cluster] > 0.0:
            normal = clusters.geometric_normal[cluster]
            direction = gather_direction(clusters, order, seeds, cluster, index % rays)
            if wp.dot(direction, normal) > 0.0:
                origin = offset_origin(clusters.position[cluster], normal, direction)
                hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        ends.hits[index] = hit

    return gather_ray_kernel


@wp.kernel
def list_unknown_kernel(first: int, ends: RayEnds) -> None:
    """One thread a ray: lists it if nothing is known of the light where it ends."""
    index = first + wp.tid()
    if ends.unknown[index] == 1:
        ends.listed[ends.totals[index] - 1] = index


def list_unknown(ends: RayEnds) -> None:
    """Fill in `totals` and `listed` of `ends`."""
    running_total(ends.unknown, ends.totals)
    launch(list_unknown_kernel, len(ends.listed), [ends], ends.listed.device)

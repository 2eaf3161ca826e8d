"""More rays for the shading points that neighbours must not speak for. Beyond the 2022 paper.

gpu.correction.outliers tells which. Their rays go to VPL clusters in proportion to what these would send were nothing
between; what clusters of SPs believe does not count. Only SPs that these rays, too, find to be much darker take what
they say.
"""

from functools import cache

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import allocate, launch
from gpu.correction.vpl_sampling import member_of, sees_member_of
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connection
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened, light_of
from gpu.vpl.group_sampling import groups_a_part, sample_group
from gpu.vpl.vpl_clusters import VplClusters, is_behind, most_groups, out_of_reach

RAYS = 32
# Groups of VPL clusters are looked at in parts, since there are few SPs to refine for a GPU's threads.
PARTS = 64
# Where more rays find more than this share of what was believed, that has less noise than they.
CONFIRMED = wp.constant(0.5)
# A cluster near a point counts at most this many times as much as its one disk, by which it is drawn.
MOST_WHOLE = wp.constant(32.0)
REFINE_KEY = wp.constant(wp.uint32(0x2C1B3C6D))


@wp.struct
class Rays:
    """Rays of refined SPs.

    mass (group, place): about the light of each group of VPL clusters were nothing between; totals (part, place): the
    sum of that over the groups of a part and of those before it; vpl (place, ray), flattened: the VPL that each ray
    goes to, −1 for none; share (place, ray), flattened: its light over its density, relative to all light, 0 once it
    was stopped.
    """

    importance: wp.array2d[float]
    importance_cdf: wp.array2d[float]
    vpl: wp.array[int]
    share: wp.array[float]


@wp.func
def disk_brightness(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, vpl: int) -> float:
    """How bright a VPL cluster's one disk is, also where it is so near that its members light the point."""
    disk = disk_at(vpls.disks, vpl)
    if is_opened(position, disk) and is_behind(position, normal, vpls, vpl):
        return 0.0
    return brightness(disk_irradiance(position, normal, disk))


@wp.kernel(module="unique", module_options={"fast_math": True})
def importance_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters,
                rays: Rays) -> None:  # fmt: skip
    """One thread a part of the VPL clusters at one SP: what its groups would send were nothing between."""
    index = first + wp.tid()
    if index >= rays.importance_cdf.shape[0] * count[0]:
        return
    place = index % count[0]
    part = index // count[0]
    position = gbuffer.position[pixels[place]]
    normal = gbuffer.normal[pixels[place]]
    groups = groups_a_part(vpls, rays.importance_cdf.shape[0])
    part_mass = float(0.0)
    for group in range(part * groups, wp.min((part + 1) * groups, vpls.groups)):
        importance = float(0.0)
        if not out_of_reach(position, normal, vpls, group):
            for vpl in range(vpls.per_group * group, wp.min(vpls.per_group * (group + 1), vpls.count)):
                importance += disk_brightness(position, normal, vpls, vpl)
        rays.importance[group, place] = importance
        part_mass += importance
    rays.importance_cdf[part, place] = part_mass


@wp.func
def all_light(rays: Rays, place: int) -> float:
    """About what all VPL clusters send an SP if nothing is between."""
    return rays.importance_cdf[rays.importance_cdf.shape[0] - 1, place]


@wp.kernel
def total_kernel(first: int, count: wp.array[int], rays: Rays) -> None:
    """One thread an SP: adds up its parts."""
    place = first + wp.tid()
    if place >= count[0]:
        return
    whole = float(0.0)
    for part in range(rays.importance_cdf.shape[0]):
        whole += rays.importance_cdf[part, place]
        rays.importance_cdf[part, place] = whole


@wp.kernel(module="unique", module_options={"fast_math": True})
def draw_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters,
                seed: wp.array[int], rays: Rays) -> None:  # fmt: skip
    """One thread a ray: draws where it goes, one of RAYS equal shares of all light for each."""
    index = first + wp.tid()
    place = index // RAYS
    rays.vpl[index] = -1
    if place >= count[0]:
        return
    whole = all_light(rays, place)
    if whole <= 0.0:
        return
    pixel = pixels[place]
    position = gbuffer.position[pixel]
    normal = gbuffer.normal[pixel]
    ray = index % RAYS
    state = hashed(wp.uint32(pixel) ^ hashed(REFINE_KEY + wp.uint32(ray) + wp.uint32(RAYS) * wp.uint32(seed[0])))
    u = (float(ray) + float(state) * TO_UNIT) / float(RAYS) * whole
    group = sample_group(vpls, rays.importance, rays.importance_cdf, place, u)
    total = float(0.0)
    expected = float(0.0)
    drawn = int(-1)
    for vpl in range(vpls.per_group * group, wp.min(vpls.per_group * (group + 1), vpls.count)):
        light = disk_brightness(position, normal, vpls, vpl)
        if light > 0.0:
            total += light
            state = hashed(state)
            if float(state) * TO_UNIT * total < light:
                drawn = vpl
                expected = light
    if drawn >= 0:
        target = member_of(position, normal, vpls, drawn, hashed(state))
        rays.vpl[index] = target.vpl
        rays.share[index] = target.share * wp.min(target.whole / expected, MOST_WHOLE)


@cache
def trace_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.device_scene.rays.connected and connected_solid."""
    sees = sees_member_of(connect)

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        vpls: VplClusters,
        rays: Rays,
    ) -> None:
        """One thread a ray: takes its light away if it is stopped."""
        index = first + wp.tid()
        vpl = rays.vpl[index]
        if vpl < 0:
            return
        if not sees(scene, gbuffer, pixels[index // RAYS], vpls, vpl):
            rays.share[index] = 0.0

    return kernel


@wp.kernel
def sum_kernel(first: int, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters, rays: Rays,
               irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a refined SP: its irradiance becomes what arrived, if that is so much less that it was not chance."""
    place = first + wp.tid()
    if place >= count[0]:
        return
    total = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(RAYS):
        index = place * RAYS + ray
        vpl = rays.vpl[index]
        if vpl >= 0:
            total += light_of(vpls, vpl, rays.share[index])
    total *= all_light(rays, place) / float(RAYS)
    if brightness(total) < CONFIRMED * brightness(irradiance[pixels[place]]):
        irradiance[pixels[place]] = total


class Refinement:
    """Re-shades up to `capacity` SPs with rays of their own; its arrays are allocated once."""

    def __init__(self, capacity: int, vpl_count: int, device: wp.Device) -> None:
        self.device, self._capacity = device, capacity
        self._rays: Rays = allocate(Rays, capacity, device, PARTS)
        self._rays.importance = wp.zeros((most_groups(vpl_count), capacity), dtype=float, device=device)
        self._rays.vpl = wp.zeros(RAYS * capacity, dtype=int, device=device)
        self._rays.share = wp.zeros(RAYS * capacity, dtype=float, device=device)

    def run(self, scene: SceneData, gbuffer: GBuffer, points: ListedPoints, vpls: VplClusters, seed: wp.array,
            irradiance: wp.array) -> None:  # fmt: skip
        """Overwrite the irradiance (pixel,) of those of `points` that rays of their own find to be much darker."""
        rays, capacity, device, pixels = self._rays, self._capacity, self.device, points.pixels
        launch(importance_kernel, PARTS * capacity, [gbuffer, pixels, points.count, vpls, rays], device)
        launch(total_kernel, capacity, [points.count, rays], device)
        launch(draw_kernel, RAYS * capacity, [gbuffer, pixels, points.count, vpls, seed, rays], device)
        launch(trace_kernel(connection(scene)), RAYS * capacity, [scene, gbuffer, pixels, vpls, rays], device)
        launch(sum_kernel, capacity, [pixels, points.count, vpls, rays, irradiance], device)

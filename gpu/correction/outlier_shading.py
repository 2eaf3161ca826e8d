"""More rays for the shading points that neighbours must not speak for. Beyond the 2022 paper.

gpu.correction.outliers tells which. Their rays go to VPL clusters in proportion to what these would send were nothing
between; what clusters of SPs believe does not count. SPs take as much light as these rays leave possible, if it is less
than what was believed: what a few rays find is too little in half of all cases, and where light comes from few places
black specks would show that.
"""

from dataclasses import dataclass
from typing import Any

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.correction.vpl_sampling import VPL_SAMPLE_PARAMETERS, VplSampleParameters, member_of
from gpu.device_scene.data import SceneData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened, light_of
from gpu.vpl.group_sampling import (
    PARTS,
    GroupTable,
    column_total,
    group_table,
    groups_a_part,
    offered,
    reservoir,
    sample_group,
    sum_parts,
)
from gpu.vpl.shadow_rays import NO_RAY, ShadowRays, colouring, ray_index, shadow_rays, target_of, trace_shadow_rays
from gpu.vpl.vpl_clusters import VplClusters, is_behind, out_of_reach

# Of each outlier: arrays have room for so many.
RAYS = 32
OUTLIER_KEY = wp.constant(wp.uint32(0x2C1B3C6D))


@wp.struct
@dataclass
class RefinementParameters:
    """How much the rays of outliers count.

    deviations: what they leave possible lies so far above what they find. With none, SPs are as dark as few rays say by
    chance; with two, too many of those that are black keep some light.
    most_whole: a cluster near a point counts at most this many times as much as its one disk, by which it is drawn.
    """

    deviations: float = 1.0
    most_whole: float = 32.0


REFINEMENT_PARAMETERS: RefinementParameters = parameters(RefinementParameters)


@wp.func
def disk_brightness(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, vpl: int) -> float:
    """How bright a VPL cluster's one disk is, also where it is so near that its members light the point."""
    disk = disk_at(vpls.disks, vpl)
    if is_opened(position, disk) and is_behind(position, normal, vpls, vpl):
        return 0.0
    return brightness(disk_irradiance(position, normal, disk))


@wp.kernel(module="unique", module_options={"fast_math": True})
def outlier_part_kernel(first: int, gbuffer: GBuffer, points: PointList, vpls: VplClusters,
                        table: GroupTable) -> None:  # fmt: skip
    """One thread a part of the VPL clusters at one SP: about what its groups would send were nothing between."""
    index = first + wp.tid()
    if index >= table.cdf.shape[0] * points.count[0]:
        return
    place = index % points.count[0]
    part = index // points.count[0]
    position = gbuffer.position[points.pixels[place]]
    normal = gbuffer.normal[points.pixels[place]]
    groups = groups_a_part(vpls, table.cdf.shape[0])
    total = float(0.0)
    for group in range(part * groups, wp.min((part + 1) * groups, vpls.groups)):
        importance = float(0.0)
        if not out_of_reach(position, normal, vpls, group):
            for vpl in range(vpls.per_group * group, wp.min(vpls.per_group * (group + 1), vpls.count)):
                importance += disk_brightness(position, normal, vpls, vpl)
        table.importance[group, place] = importance
        total += importance
    table.cdf[part, place] = total


@wp.kernel(module="unique", module_options={"fast_math": True})
def outlier_ray_kernel(first: int, gbuffer: GBuffer, points: PointList, vpls: VplClusters, table: GroupTable,
                       seed: wp.array[int], rays: ShadowRays, limits: VplSampleParameters,
                       by: RefinementParameters) -> None:  # fmt: skip
    """One thread a ray: draws where it goes, one of RAYS equal shares of all light for each. seed: (1,)."""
    index = first + wp.tid()
    place = index // RAYS
    if place >= points.count[0]:
        return
    rays.vpl[index] = NO_RAY
    whole = column_total(table, place)
    if whole <= 0.0:
        return
    pixel = points.pixels[place]
    position = gbuffer.position[pixel]
    normal = gbuffer.normal[pixel]
    ray = index % RAYS
    state = hashed(wp.uint32(pixel) ^ hashed(OUTLIER_KEY + wp.uint32(ray) + wp.uint32(RAYS) * wp.uint32(seed[0])))
    u = (float(ray) + float(state) * TO_UNIT) / float(RAYS) * whole
    group = sample_group(vpls, table, place, u)
    drawn = reservoir(state)
    for vpl in range(vpls.per_group * group, wp.min(vpls.per_group * (group + 1), vpls.count)):
        light = disk_brightness(position, normal, vpls, vpl)
        if light > 0.0:
            drawn = offered(drawn, vpl, light)
    if drawn.item >= 0:
        target = member_of(position, normal, vpls, drawn.item, hashed(drawn.state), limits)
        rays.vpl[index] = target.vpl
        rays.share[index] = target.share * wp.min(target.whole / drawn.weight, by.most_whole)


@wp.func
def most_visible(share: float, rays: float, deviations: float) -> float:
    """The most of all light that may arrive where this `share` of so many `rays` did: the upper end of E. B. Wilson's
    score interval (Probable Inference, 1927), so many deviations wide. Rays that count more make shares above 1.
    """
    part = deviations * deviations / rays
    radius = deviations * wp.sqrt(wp.max(share * (1.0 - share), 0.0) / rays + 0.25 * part / rays)
    return wp.max((share + 0.5 * part + radius) / (1.0 + part), share)


@wp.kernel
def outlier_irradiance_kernel(first: int, points: PointList, vpls: VplClusters, table: GroupTable, rays: ShadowRays,
                              irradiance: wp.array[wp.vec3], by: RefinementParameters) -> None:  # fmt: skip
    """One thread an SP: its irradiance becomes the most that may arrive, if that is less.

    What did not arrive has the colour that was believed. Rays that count differently tell as little as fewer of them.
    """
    place = first + wp.tid()
    if place >= points.count[0]:
        return
    total = wp.vec3(0.0, 0.0, 0.0)
    shares = float(0.0)
    squares = float(0.0)
    for ray in range(RAYS):
        index = ray_index(rays, place, ray)
        vpl = target_of(rays.vpl[index])
        if vpl != NO_RAY:
            share = rays.share[index]
            shares += share
            squares += share * share
            if rays.vpl[index] == vpl:
                sent = light_of(vpls, vpl, share)
                total += sent + wp.cw_mul(sent, colouring(rays, index))
    whole = column_total(table, place)
    found = total * (whole / float(RAYS))
    arrived = brightness(total) / float(RAYS)
    most = most_visible(arrived, wp.max(shares * shares / wp.max(squares, 1.0e-20), 1.0), by.deviations)
    pixel = points.pixels[place]
    believed = brightness(irradiance[pixel])
    if whole * most < believed:
        irradiance[pixel] = found + irradiance[pixel] * (whole * (most - arrived) / believed)


class Refinement:
    """Re-shades up to `capacity` SPs with rays of their own; its arrays are allocated once.

    A ray's share is its VPL's light over its density, relative to all light. quality: RefinementParameters; tinted: as
    of `shadow_rays`.
    """

    def __init__(self, capacity: int, vpl_count: int, device: wp.Device, quality: Any = REFINEMENT_PARAMETERS, *,
                 tinted: bool = False) -> None:  # fmt: skip
        self.device, self._capacity, self._quality = device, capacity, quality
        self._table = group_table(vpl_count, capacity, device)
        self._rays = shadow_rays(capacity, RAYS, device, side_by_side=True, control_variate=False, tinted=tinted)

    def run(self, scene: SceneData, gbuffer: GBuffer, points: ListedPoints, vpls: VplClusters, seed: wp.array,
            irradiance: wp.array) -> None:  # fmt: skip
        """Overwrite the irradiance (pixel,) [W/m²] of those of `points` that rays of their own find to be much darker.

        seed: (1,), the frame's.
        """
        listed, table, rays, capacity, device = points.points, self._table, self._rays, self._capacity, self.device
        launch(outlier_part_kernel, PARTS * capacity, [gbuffer, listed, vpls, table], device)
        sum_parts(table, capacity, listed.count)
        inputs = [gbuffer, listed, vpls, table, seed, rays, VPL_SAMPLE_PARAMETERS, self._quality]
        launch(outlier_ray_kernel, RAYS * capacity, inputs, device)
        trace_shadow_rays(scene, gbuffer, listed, vpls, rays)
        launch(outlier_irradiance_kernel, capacity, [listed, vpls, table, rays, irradiance, self._quality], device)

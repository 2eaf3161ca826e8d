"""The light that VPLs send single points, by rays that clusters only direct: right in the mean over light sets.

All rays of an SP but one go to members of VPL clusters in proportion to what its clusters know of their light, one to
one of a few VPLs drawn from all, and what a VPL sends counts by how probable both make it (importance sampling with the
balance heuristic, Veach 1997, 9.2). So what clusters get wrong costs noise and nothing else. A VPL's 1/(π·d²) is
bounded to 1/(π·d² + A), with an area A that its place alone decides; gpu.correction.bias_compensation adds what that
leaves out, so that both together are what path tracing finds (T. Kollig and A. Keller, Illumination in the Presence of
Weak Singularities, 2004).
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.correction.vpl_sampling import ClusterSample, VplSampleParameters, far_member, far_sample_of
from gpu.device_scene.data import SceneData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.clustered_light import ClusteredLight, cluster_visibility_of, guides_of
from gpu.indirect.far_field import visibility_weight
from gpu.indirect.fuzzy_shading import REGISTERS
from gpu.indirect.irradiance import CHECKS, Indirect
from gpu.indirect.received_lobes import received_by_lobe
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened, light_of, member_irradiance, unoccluded_irradiance
from gpu.vpl.group_sampling import offered, reservoir
from gpu.vpl.shadow_rays import NO_RAY, ShadowRays, colouring, trace_shadow_rays
from gpu.vpl.vpl_clusters import VplClusters, cluster_of
from gpu.vpl.vpl_lobes import VplLobes, by_lobe

CONNECTION_KEY = wp.constant(wp.uint32(0x7F4A7C15))
# A ray counts for all that it stands for: a bound would take light away.
UNBOUNDED = parameters(VplSampleParameters, most_share=float(FAR_AWAY))


@dataclass(frozen=True)
class ConnectionParameters:
    """candidates: VPLs drawn from all, of which one gets a ray, in proportion to their light (Talbot et al. 2005)."""

    candidates: int = 16


CONNECTION_PARAMETERS = ConnectionParameters()


@wp.struct
class Connections:
    """A pass of rays, of which each SP sends CHECKS: number `number` of `passes`.

    areas (vpl,): A of each VPL's bound, unit space squared; lobes: of VPLs; seed: of the frame.
    """

    number: int
    passes: int
    seed: int
    areas: wp.array[float]
    lobes: VplLobes


@wp.func
def drawn_member(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, areas: wp.array[float],
                 state: wp.uint32) -> int:  # fmt: skip
    """A member of a cluster: of a far one in proportion to its flux, of a near one to its light."""
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    disk = disk_at(vpls.disks, cluster)
    if not is_opened(position, disk):
        return far_member(vpls, cluster, disk.area, state)
    drawn = reservoir(state)
    for vpl in range(begin, end):
        drawn = offered(drawn, vpl, brightness(member_irradiance(position, normal, vpls, vpl, areas[vpl])))
    return drawn.item


@wp.func
def member_probability(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, areas: wp.array[float],
                       member: int, light: float) -> float:  # fmt: skip
    """Of the choice of a member with so much `light` by `drawn_member`."""
    disk = disk_at(vpls.disks, cluster)
    if not is_opened(position, disk):
        return vpls.member_area[member] / disk.area
    total = float(0.0)
    for vpl in range(vpls.starts[cluster], vpls.starts[cluster + 1]):
        total += brightness(member_irradiance(position, normal, vpls, vpl, areas[vpl]))
    return light / total


@cache
def cluster_probability_of(fuzziness: int) -> wp.Function:
    """The function that tells how probable a VPL cluster is among the guided rays of an SP of F = `fuzziness` clusters.

    whole: the importance of all light.
    """

    @wp.func
    def is_near(guided: Any, known: ClusteredLight, vpl: int) -> bool:
        near = wp.uint32(0)
        for f in range(wp.static(fuzziness)):
            if guided.weight[f] > 0.0:
                near |= known.far.near[guided.cluster[f], vpl // 32]
        return ((near >> wp.uint32(vpl % 32)) & wp.uint32(1)) == wp.uint32(1)

    @wp.func
    def cluster_probability(position: wp.vec3, normal: wp.vec3, guided: Any, known: ClusteredLight, cluster: int,
                            whole: float) -> float:  # fmt: skip
        vpls = known.vpls
        weight = visibility_weight(cluster_visibility_of(guided, known.visibility, cluster, wp.static(fuzziness)))
        if is_near(guided, known, cluster):
            return brightness(unoccluded_irradiance(position, normal, vpls, cluster)) * weight / whole
        amount = brightness(disk_irradiance(position, normal, disk_at(vpls.disks, cluster))) * weight
        group = cluster // vpls.per_group
        expected = float(0.0)
        for f in range(wp.static(fuzziness)):
            if guided.weight[f] > 0.0:
                expected += guided.weight[f] * known.far.weighted.importance[group, guided.cluster[f]]
        if amount <= 0.0 or expected <= 0.0:
            return 0.0
        total = float(0.0)
        first_vpl = vpls.per_group * group
        for vpl in range(first_vpl, wp.min(first_vpl + vpls.per_group, vpls.count)):
            if not is_near(guided, known, vpl):
                share = cluster_visibility_of(guided, known.visibility, vpl, wp.static(fuzziness))
                light = brightness(disk_irradiance(position, normal, disk_at(vpls.disks, vpl)))
                total += light * visibility_weight(share)
        return amount / total * expected / whole

    return cluster_probability


@cache
def connection_ray_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws rays of SPs of F = `fuzziness` clusters each."""
    guides, sample_far = guides_of(fuzziness), far_sample_of(fuzziness, weighted=True)
    cluster_probability = cluster_probability_of(fuzziness)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def connection_ray_kernel(
        first: int,
        gbuffer: GBuffer,
        points: PointList,
        known: ClusteredLight,
        this_pass: Connections,
        indirect: Indirect,
        rays: ShadowRays,
        limits: VplSampleParameters,
    ) -> None:
        """One thread a ray of a pass: draws to which VPL it goes, and what that sends if nothing hides it.

        The first ray goes to one of some that are drawn from all VPLs, and has the weight of one; all others of an SP
        take equal shares of what its clusters know.
        """
        index = first + wp.tid()
        sp = index // CHECKS
        check = index % CHECKS
        if sp >= points.count[0]:
            return
        rays.vpl[index] = NO_RAY
        near_importance = indirect.near_importance[sp]
        far_importance = indirect.far_importance[sp]
        whole = near_importance + far_importance
        pixel = points.pixels[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        vpls = known.vpls
        ray = this_pass.number * CHECKS + check
        key = hashed(CONNECTION_KEY + wp.uint32(ray) + wp.uint32(CHECKS * this_pass.passes) * wp.uint32(this_pass.seed))
        state = hashed(wp.uint32(pixel) ^ key)
        guided = guides(known, sp, position, normal)
        vpl = int(-1)
        counted = float(0.0)
        guided_rays = float(CHECKS * this_pass.passes - 1)
        if ray == 0:
            resampled = reservoir(hashed(state))
            for number in range(wp.static(CONNECTION_PARAMETERS.candidates)):
                any_vpl = int(hashed(state + wp.uint32(number)) % wp.uint32(vpls.members.count))
                light = brightness(member_irradiance(position, normal, vpls, any_vpl, this_pass.areas[any_vpl]))
                if light > 0.0:
                    resampled = offered(resampled, any_vpl, light)
            vpl = resampled.item
            counted = resampled.total / float(wp.static(CONNECTION_PARAMETERS.candidates))
        elif whole > 0.0:
            u = (float(ray - 1) + float(hashed(state)) * TO_UNIT) / guided_rays * whole - near_importance
            drawn = ClusterSample()
            drawn.cluster = indirect.target[check, sp]
            drawn.state = state
            if u >= 0.0:
                pick = wp.vec2(float(state) * TO_UNIT * far_importance, u / far_importance)
                drawn = sample_far(position, normal, guided, known, pick, state, limits)
            if drawn.cluster >= 0:
                vpl = drawn_member(position, normal, vpls, drawn.cluster, this_pass.areas, hashed(drawn.state))
        if vpl < 0:
            return
        light = brightness(member_irradiance(position, normal, vpls, vpl, this_pass.areas[vpl]))
        if light > 0.0:
            rays.vpl[index] = vpl
            density = 1.0 / float(vpls.members.count)
            if whole > 0.0:
                cluster = cluster_of(vpls, vpl)
                probable = cluster_probability(position, normal, guided, known, cluster, whole)
                if probable > 0.0:
                    probable *= member_probability(position, normal, vpls, cluster, this_pass.areas, vpl, light)
                density += guided_rays * probable
            rays.share[index] = wp.where(ray == 0, counted, light) / density

    return connection_ray_kernel


@wp.kernel
def connected_light_kernel(first: int, gbuffer: GBuffer, points: PointList, vpls: VplClusters, rays: ShadowRays,
                           this_pass: Connections, irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: adds what arrived to that of the passes before, irradiance (pixel,) [W/m²]."""
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    light = wp.vec3(0.0, 0.0, 0.0)
    if this_pass.number > 0:
        light = irradiance[pixel]
    for check in range(CHECKS):
        index = sp * CHECKS + check
        vpl = rays.vpl[index]
        if vpl >= 0:
            way = wp.normalize(gbuffer.position[pixel] - vpls.members.position[vpl])
            sent = light_of(vpls, vpl, rays.share[index])
            sent += wp.cw_mul(sent, colouring(rays, index))
            sent = wp.cw_mul(sent, by_lobe(this_pass.lobes, vpls.members, vpl, way))
            light += wp.cw_mul(sent, received_by_lobe(gbuffer, pixel, -way))
    irradiance[pixel] = light


def connect(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, known: ClusteredLight, indirect: Indirect,
            rays: ShadowRays, these: Connections) -> None:  # fmt: skip
    """Overwrite the irradiance of `sps`, which were shaded by what is `known`, with what VPLs send them.

    rays: CHECKS for each SP; these: with the number of passes, areas, lobes and seed.
    """
    draw, points, device = connection_ray_kernel(known.clusters.cluster.shape[0]), sps.points, sps.device
    for number in range(these.passes):
        these.number = number
        inputs = [gbuffer, points, known, these, indirect, rays, UNBOUNDED]
        launch(draw, CHECKS * sps.capacity, inputs, device)
        trace_shadow_rays(scene, gbuffer, points, known.vpls, rays)
        inputs = [gbuffer, points, known.vpls, rays, these, indirect.irradiance]
        launch(connected_light_kernel, sps.capacity, inputs, device)

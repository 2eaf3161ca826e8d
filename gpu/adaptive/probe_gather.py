"""The light of all VPLs at some pixels (gpu.adaptive.error_probes), by few rays: even steps through all light that
may arrive.

What a VPL would send, were nothing in between, is its share in that light; each step has one ray, to the VPL that it
falls into. Rays for runs of VPLs, one for each, leave 3 to 40 times the variance, since most light is often that of few
runs. A cluster that is far for its extent, and faces the pixel well, is one share of the light, by what stands for it;
rays that fall into it go to any of its members and count by what that sends, so nothing is off but for noise.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, light_of, member_irradiance
from gpu.vpl.group_sampling import PARTS, GroupTable, sum_parts
from gpu.vpl.shadow_rays import NO_RAY, ShadowRays, colouring, shadow_rays, trace_shadow_rays
from gpu.vpl.vpl_clusters import VplClusters, is_behind

# Rays of an estimate at a probe: arrays have room for so many. They leave less noise than the choice of pixels does;
# half as many leave more in a Cornell box (of 16,384 probes 4.6 percent of the error, not 3.0).
RAYS = wp.constant(64)
NOT, AS_ONE, BY_MEMBERS = wp.constant(0), wp.constant(1), wp.constant(2)


@wp.struct
@dataclass
class ProbeLightParameters:
    """far_extents: so many times its extent is a cluster away that is one share of the light."""

    far_extents: float = 4.0


PROBE_LIGHT_PARAMETERS: ProbeLightParameters = parameters(ProbeLightParameters)


@wp.func
def way_to_look(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, by: ProbeLightParameters) -> int:
    """How to look at a cluster from a point: NOT where no member lights it, AS_ONE where all do much as its disk does.

    Of the latter each member has at most 14 times its share of the disk's light. Else BY_MEMBERS.
    """
    disk = disk_at(vpls.disks, cluster)
    extent = vpls.extent[cluster]
    normal_cone_cos = vpls.normal_cone_cos[cluster]
    way = disk.position - position
    away = wp.length(way)
    facing = wp.dot(way, normal)
    leaving = -wp.dot(way, disk.normal)
    turned = away * wp.sqrt(wp.max(1.0 - normal_cone_cos * normal_cone_cos, 0.0)) + extent
    if facing <= -extent or leaving * normal_cone_cos < -turned:
        return NOT
    if away > by.far_extents * extent and facing > extent and leaving > turned:
        return AS_ONE
    if is_behind(position, normal, vpls, cluster):
        return NOT
    return BY_MEMBERS


@wp.func
def light_at(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, vpl: int) -> float:
    """Brightness of what a VPL, a disk of its own, sends to a point, were nothing in between [W/m²]."""
    return brightness(member_irradiance(position, normal, vpls, vpl, vpls.member_area[vpl]))


@wp.kernel(module="unique", module_options={"fast_math": True})
def probe_part_kernel(first: int, gbuffer: GBuffer, points: PointList, vpls: VplClusters, by: ProbeLightParameters,
                      parts: wp.array2d[float]) -> None:  # fmt: skip
    """One thread a part at a probe: the light of its VPLs, in parts (part, probe). points: the probes.

    Neighbouring threads have the same VPLs.
    """
    index = first + wp.tid()
    probe = index % points.pixels.shape[0]
    part = index // points.pixels.shape[0]
    pixel = points.pixels[probe]
    total = float(0.0)
    if gbuffer.face[pixel] != NO_HIT:
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        for cluster in range((part * vpls.count) // PARTS, ((part + 1) * vpls.count) // PARTS):
            look = way_to_look(position, normal, vpls, cluster, by)
            disk = disk_at(vpls.disks, cluster)
            if look == AS_ONE:
                total += brightness(disk_irradiance(position, normal, disk))
            if look == BY_MEMBERS:
                begin = vpls.starts[cluster]
                end = vpls.starts[cluster + 1]
                for vpl in range(begin, end):
                    total += light_at(position, normal, vpls, vpl)
    parts[part, probe] = total


@wp.func
def step_at(probe: int, estimate: int, ray: int, frame: int, whole: float) -> float:
    """Where a ray of one of the two estimates falls in the light at its probe, evenly within its step."""
    if ray >= RAYS:
        return FAR_AWAY
    key = wp.uint32((probe * 2 + estimate) * RAYS + ray)
    return (float(ray) + float(hashed(key ^ hashed(wp.uint32(frame)))) * TO_UNIT) / float(RAYS) * whole


@wp.kernel(module="unique", module_options={"fast_math": True})
def probe_ray_kernel(first: int, gbuffer: GBuffer, points: PointList, frame: wp.array[int], vpls: VplClusters,
                     by: ProbeLightParameters, parts: wp.array2d[float], rays: ShadowRays) -> None:  # fmt: skip
    """One thread a part at a probe, of one estimate: which of its VPLs the rays go to whose steps it holds.

    frame: (1,). Neighbouring threads have the same VPLs.
    """
    index = first + wp.tid()
    probe = index % points.pixels.shape[0]
    estimate = index // points.pixels.shape[0] % 2
    part = index // points.pixels.shape[0] // 2
    most = parts[part, probe]
    total = float(0.0)
    if part > 0:
        total = parts[part - 1, probe]
    if not most > total:
        return
    whole = parts[PARTS - 1, probe]
    ray = wp.max(int(total / whole * float(RAYS)) - 1, 0)
    step = step_at(probe, estimate, ray, frame[0], whole)
    while step < total:
        ray += 1
        step = step_at(probe, estimate, ray, frame[0], whole)
    if step >= most:
        return
    pixel = points.pixels[probe]
    position = gbuffer.position[pixel]
    normal = gbuffer.normal[pixel]
    first_ray = (2 * probe + estimate) * RAYS
    a_step = whole / float(RAYS)
    last = int(-1)
    for cluster in range((part * vpls.count) // PARTS, ((part + 1) * vpls.count) // PARTS):
        look = way_to_look(position, normal, vpls, cluster, by)
        disk = disk_at(vpls.disks, cluster)
        begin = vpls.starts[cluster]
        end = vpls.starts[cluster + 1]
        number = float(end - begin)
        if look == AS_ONE:
            light = brightness(disk_irradiance(position, normal, disk))
            before = total
            total += light
            while step < wp.min(total, most):
                last = wp.min(begin + int((step - before) / light * number), end - 1)
                rays.vpl[first_ray + ray] = last
                rays.share[first_ray + ray] = a_step * light_at(position, normal, vpls, last) * number / light
                ray += 1
                step = step_at(probe, estimate, ray, frame[0], whole)
            last = end - 1
        if look == BY_MEMBERS:
            for vpl in range(begin, end):
                light = light_at(position, normal, vpls, vpl)
                if light > 0.0:
                    total += light
                    last = vpl
                    while step < wp.min(total, most):
                        rays.vpl[first_ray + ray] = vpl
                        rays.share[first_ray + ray] = a_step
                        ray += 1
                        step = step_at(probe, estimate, ray, frame[0], whole)
        if step >= most:
            return
    # By rounding, a part may end a little short.
    while step < most:
        rays.vpl[first_ray + ray] = last
        rays.share[first_ray + ray] = a_step
        ray += 1
        step = step_at(probe, estimate, ray, frame[0], whole)


@wp.kernel
def probe_light_kernel(first: int, vpls: VplClusters, rays: ShadowRays, light: wp.array[wp.vec3]) -> None:
    """One thread an estimate at a probe: the light of its rays that arrived, in light (probe, estimate) [W/m²]."""
    estimate = first + wp.tid()
    total = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(RAYS):
        index = estimate * RAYS + ray
        vpl = rays.vpl[index]
        if vpl >= 0:
            sent = light_of(vpls, vpl, rays.share[index])
            total += sent + wp.cw_mul(sent, colouring(rays, index))
    light[estimate] = total


class ProbeLight:
    """The light at `count` probes; its arrays are allocated once. light: (probe, 2), flattened [W/m²]."""

    def __init__(self, count: int, device: wp.Device, *, tinted: bool = False) -> None:
        """tinted: as of `shadow_rays`."""
        self.device, self.capacity = device, count
        # A part's light, and then that of the parts before it too: what all threads of a probe compare with is computed
        # once, since sums that round otherwise would lose rays.
        self._parts = GroupTable()
        self._parts.cdf = wp.zeros((PARTS, count), dtype=float, device=device)
        by_ray = {"side_by_side": True, "control_variate": False, "tinted": tinted}
        self._rays = shadow_rays(count, 2 * int(RAYS), device, **by_ray)
        self.light = wp.zeros(2 * count, dtype=wp.vec3, device=device)

    def gather(self, scene: SceneData, gbuffer: GBuffer, points: PointList, frame: wp.array, vpls: VplClusters) -> None:
        """Two estimates of the light of `vpls` at `points`; other rays in each `frame` (1,)."""
        count, device, parts, rays = self.capacity, self.device, self._parts, self._rays
        looks = [vpls, PROBE_LIGHT_PARAMETERS, parts.cdf]
        launch(probe_part_kernel, count * PARTS, [gbuffer, points, *looks], device)
        sum_parts(parts, count, points.count)
        rays.vpl.fill_(int(NO_RAY))
        launch(probe_ray_kernel, count * 2 * PARTS, [gbuffer, points, frame, *looks, rays], device)
        trace_shadow_rays(scene, gbuffer, points, vpls, rays)
        launch(probe_light_kernel, 2 * count, [vpls, rays, self.light], device)

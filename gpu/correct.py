"""Rays from shading points themselves that correct what their clusters believe. Beyond the 2022 paper.

Fuzzy visibility is a control variate: an SP sends a few rays towards light that some of its clusters see, drawn in
proportion to it, and the difference between what a ray finds and what the clusters believed is an unbiased estimate of
their error there. It is zero where they are right, so its noise is small, and neighbours on a surface share it. Rays
end at members of VPL clusters, so that what clustering VPLs does to penumbrae is corrected, too.
"""

from functools import cache

import warp as wp

from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import CHECKS, HIDDEN_CHECK, Indirect, doubt
from gpu.shading_points import ShadingPoints
from gpu.transfer import brightness, disk_irradiance, disk_transfer, is_unfolded
from gpu.vpl_clusters import VplClusters

CHECK_KEY = wp.constant(wp.uint32(0x5BD1E995))


# A member of a cluster counts at most this many times as much as its cluster lets expect.
MOST_SHARE = wp.constant(4.0)


@wp.struct
class Target:
    """A VPL that a ray goes to, and its light over what its cluster lets expect of it."""

    vpl: int
    share: float


@wp.func
def member_of(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, state: wp.uint32) -> Target:
    """A member of a VPL cluster, drawn in proportion to its light where members are shaded one by one."""
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    number = float(end - begin)
    target = Target()
    if not is_unfolded(position, vpls, cluster):
        target.vpl = begin + int(hashed(state) % wp.uint32(end - begin))
        way = vpls.members.position[target.vpl] - position
        light = disk_transfer(way, normal, vpls.members.normal[target.vpl], vpls.area[cluster])
        light *= brightness(vpls.members.flux[target.vpl]) * number
        expected = brightness(disk_irradiance(position, normal, vpls, cluster))
        target.share = wp.min(light / expected, MOST_SHARE)
        return target
    target.vpl = begin
    target.share = 1.0
    area = vpls.area[cluster] / number
    total = float(0.0)
    for member in range(begin, end):
        way = vpls.members.position[member] - position
        light = disk_transfer(way, normal, vpls.members.normal[member], area) * brightness(vpls.members.flux[member])
        total += light
        state = hashed(state)
        if float(state) * TO_UNIT * total < light:
            target.vpl = member
    return target


@wp.struct
class Checks:
    """Rays of SPs, (check, sp) flattened: the VPL that each goes to, −1 for none, and its share.

    share: the VPL's light over what its cluster lets expect, and, once traced, by how much the SP's clusters are wrong,
    in units of the light in doubt.
    """

    vpl: wp.array[int]
    share: wp.array[float]


@wp.kernel
def draw_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], count: wp.array[int], vpls: VplClusters, seed: int,
                indirect: Indirect, checks: Checks) -> None:  # fmt: skip
    """One thread a ray: draws to which member of its VPL cluster it goes."""
    index = first + wp.tid()
    sp = index % sps.shape[0]
    check = index // sps.shape[0]
    checks.vpl[index] = -1
    if sp >= count[0] or indirect.target[check, sp] < 0:
        return
    pixel = sps[sp]
    state = hashed(wp.uint32(pixel) ^ hashed(CHECK_KEY + wp.uint32(check) + wp.uint32(CHECKS) * wp.uint32(seed)))
    target = member_of(gbuffer.position[pixel], gbuffer.normal[pixel], vpls, indirect.target[check, sp], state)
    checks.vpl[index] = target.vpl
    checks.share[index] = target.share


@cache
def check_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        sps: wp.array[int],
        vpls: VplClusters,
        indirect: Indirect,
        checks: Checks,
    ) -> None:
        """One thread a ray: by how much the SP's clusters are wrong about what it finds, over its density."""
        index = first + wp.tid()
        vpl = checks.vpl[index]
        if vpl < 0:
            return
        sp = index % sps.shape[0]
        pixel = sps[sp]
        position = vpls.members.position[vpl]
        normal = vpls.members.normal[vpl]
        believed = indirect.believed[index // sps.shape[0], sp]
        seen = float(0.0)
        if connect(scene, gbuffer.position[pixel], gbuffer.geometric[pixel], position, normal):
            seen = 1.0
        wrong = seen - believed
        if index // sps.shape[0] != HIDDEN_CHECK:
            wrong = wrong / doubt(believed)
        checks.share[index] = checks.share[index] * wrong

    return kernel


@wp.kernel
def correction_kernel(first: int, sps: wp.array[int], count: wp.array[int], vpls: VplClusters, checks: Checks,
                      indirect: Indirect, correction: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: the mean over its rays of what is to be added to its irradiance, in correction (pixel,)."""
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    total = wp.vec3(0.0, 0.0, 0.0)
    for check in range(CHECKS):
        index = check * sps.shape[0] + sp
        vpl = checks.vpl[index]
        if vpl >= 0:
            whole = indirect.doubted[sp] / float(CHECKS - 1)
            if check == HIDDEN_CHECK:
                whole = indirect.hidden[sp]
            flux = vpls.members.flux[vpl]
            total += flux * (checks.share[index] * whole / brightness(flux))
    correction[sps[sp]] = total


class Correction:
    """Checks the light of up to `capacity` SPs; its arrays are allocated once.

    own (pixel,): what the irradiance of each SP lacks by its own rays, or has too much of, then negative [W/m²].
    """

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.device = device
        self.own = wp.zeros(capacity, dtype=wp.vec3, device=device)
        self._checks = Checks()
        self._checks.vpl = wp.zeros(CHECKS * capacity, dtype=int, device=device)
        self._checks.share = wp.zeros(CHECKS * capacity, dtype=float, device=device)

    def trace(
        self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, seed: int, indirect: Indirect
    ) -> None:
        """Check the light of `sps`."""
        points, rays = [gbuffer, sps.pixels], CHECKS * sps.capacity
        inputs = [*points, sps.count, vpls, seed, indirect, self._checks]
        launch(draw_kernel, rays, inputs, self.device)
        launch(check_kernel(connection(scene)), rays, [scene, *points, vpls, indirect, self._checks], self.device)
        inputs = [sps.pixels, sps.count, vpls, self._checks, indirect, self.own]
        launch(correction_kernel, sps.capacity, inputs, self.device)

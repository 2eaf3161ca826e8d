"""Rays from shading points themselves that correct what their clusters believe. Beyond the 2022 paper.

Fuzzy visibility is a control variate: an SP sends a few rays to VPL clusters, drawn in proportion to their light and
to how far its clusters may be wrong about them (gpu.far_light.doubt). The difference between what a ray finds and what
the clusters believed estimates their error, and is right in the mean. It is zero where they are right, so its noise is
small, and neighbours on a surface share it. Rays end at members of VPL clusters, so that what clustering VPLs does to
penumbrae is corrected, too.
"""

from functools import cache
from typing import Any

import warp as wp

from gpu.device import allocate, launch
from gpu.disk import disk_at
from gpu.draws import drawn_group
from gpu.far_light import LEAST_DOUBT, FarLight, doubt
from gpu.gbuffer import GBuffer
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import CHECKS, REGISTERS, Indirect, guides_of
from gpu.shading_points import ListedPoints
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, disk_irradiance, is_twig_unfolded, is_unfolded, member_irradiance
from gpu.vpl_clusters import PER_TWIG, VplClusters

CHECK_KEY = wp.constant(wp.uint32(0x5BD1E995))
# A member of a cluster counts at most this many times as much as its cluster lets expect, and a group of clusters as
# much as the SP's clusters do.
MOST_SHARE = wp.constant(4.0)
# Between the seeds of several passes.
PASS_SEED = wp.constant(wp.uint32(0x3C6EF372))


@wp.struct
class Target:
    """A VPL that a ray goes to, and its light over what its cluster lets expect of it.

    whole: brightness of the cluster were nothing between.
    """

    vpl: int
    share: float
    whole: float


@wp.func
def member_of(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, state: wp.uint32) -> Target:
    """A member of a VPL cluster, drawn in proportion to its light where members are shaded one by one."""
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    number = float(end - begin)
    target = Target()
    disk = disk_at(vpls.disks, cluster)
    if not is_unfolded(position, disk):
        target.vpl = begin + int(hashed(state) % wp.uint32(end - begin))
        light = brightness(member_irradiance(position, normal, vpls, target.vpl, disk.area)) * number
        target.whole = brightness(disk_irradiance(position, normal, disk))
        target.share = wp.min(light / target.whole, MOST_SHARE)
        return target
    target.vpl = begin
    target.share = 1.0
    chosen = int(begin)
    area = disk.area / number
    total = float(0.0)
    for twig in range(vpls.twig_starts[cluster], vpls.twig_starts[cluster + 1]):
        disk = disk_at(vpls.twigs, twig)
        last = wp.min(begin + PER_TWIG, end)
        light = float(0.0)
        if is_twig_unfolded(position, disk):
            for member in range(begin, last):
                light += brightness(member_irradiance(position, normal, vpls, member, area))
        else:
            light = brightness(disk_irradiance(position, normal, disk))
        total += light
        state = hashed(state)
        if float(state) * TO_UNIT * total < light:
            chosen = begin
        begin = last
    target.whole = total
    total = float(0.0)
    for member in range(chosen, wp.min(chosen + PER_TWIG, end)):
        light = brightness(member_irradiance(position, normal, vpls, member, area))
        total += light
        state = hashed(state)
        if float(state) * TO_UNIT * total < light:
            target.vpl = member
    return target


@wp.struct
class Checks:
    """Rays of listed SPs, (place, check) flattened: those of one SP run side by side.

    vpl: that each goes to, −1 for none; believed: the share of the SP's clusters that see it; share: its light over its
    density [W/m²], and, once traced, times what the SP's clusters are wrong by.
    """

    vpl: wp.array[int]
    believed: wp.array[float]
    share: wp.array[float]


@wp.struct
class Guide:
    """One of an SP's clusters, −1 for none, and what is left of a pick of its light in doubt."""

    cluster: int
    pick: float


@cache
def guide_at_of(fuzziness: int) -> wp.Function:
    """The function that finds which of an SP's F = `fuzziness` clusters a pick of their far light falls into.

    pick: from 0 to the sum of what they know, each by its share; totals (part, cluster): of gpu.far_light.FarLight.
    """

    @wp.func
    def guide_at(guided: Any, totals: wp.array2d[float], pick: float) -> Guide:
        guide = Guide()
        guide.cluster = -1
        for f in range(wp.static(fuzziness)):
            mass = guided.weight[f] * totals[totals.shape[0] - 1, guided.cluster[f]]
            if mass > 0.0:
                guide.cluster = guided.cluster[f]
                guide.pick = pick
                if pick < mass:
                    guide.pick = pick / guided.weight[f]
                    break
                pick -= mass
                guide.pick = pick
        return guide

    return guide_at


@wp.struct
class FarDraw:
    """A far VPL cluster that a ray goes to, −1 for none, and the share of the SP's clusters that see it.

    scale: what the group that it is of sends the SP, over what the SP's clusters let expect; state: of draws.
    """

    cluster: int
    believed: float
    scale: float
    state: wp.uint32


@cache
def far_draw_of(fuzziness: int) -> wp.Function:
    """The function that draws a far VPL cluster for an SP of F = `fuzziness` clusters, `guided` by them.

    In proportion to light, where all clusters take it for hidden to the share `least` of that: mass, totals are the
    tables of gpu.far_light.FarLight that have it so; guide: where in them.
    """
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)

    @wp.func
    def far_draw(position: wp.vec3, normal: wp.vec3, guided: Any, visibility: wp.array2d[wp.uint32], vpls: VplClusters,
                 near_bits: wp.array2d[wp.uint32], mass: wp.array2d[float], totals: wp.array2d[float], least: float,
                 guide: Guide, state: wp.uint32) -> FarDraw:  # fmt: skip
        draw = FarDraw()
        draw.cluster = -1
        draw.state = state
        if guide.cluster < 0:
            return draw
        cluster = guided.cluster
        weights = guided.weight
        group = drawn_group(vpls, mass, totals, guide.cluster, guide.pick)
        expected = float(0.0)
        for f in range(wp.static(fuzziness)):
            if weights[f] > 0.0:
                expected += weights[f] * mass[group, cluster[f]]
        if expected <= 0.0:
            return draw
        seen = words_type()
        total = float(0.0)
        near = wp.uint32(0)
        first_vpl = vpls.per_group * group
        for vpl in range(first_vpl, wp.min(first_vpl + vpls.per_group, vpls.count)):
            if vpl == first_vpl or vpl % 32 == 0:
                near = wp.uint32(0)
                for f in range(wp.static(fuzziness)):
                    seen[f] = visibility[cluster[f], vpl // 32]
                    if weights[f] > 0.0:
                        near |= near_bits[cluster[f], vpl // 32]
            bit = wp.uint32(vpl % 32)
            amount = brightness(disk_irradiance(position, normal, disk_at(vpls.disks, vpl)))
            if amount > 0.0 and ((near >> bit) & wp.uint32(1)) == wp.uint32(0):
                share = float(0.0)
                for f in range(wp.static(fuzziness)):
                    share += weights[f] * float((seen[f] >> bit) & wp.uint32(1))
                amount *= least + (1.0 - least) * share
                total += amount
                draw.state = hashed(draw.state)
                if float(draw.state) * TO_UNIT * total < amount:
                    draw.cluster = vpl
                    draw.believed = share
        draw.scale = wp.min(total / expected, MOST_SHARE)
        return draw

    return far_draw


@wp.func
def believed_share(guided: Any, visibility: wp.array2d[wp.uint32], cluster: int, fuzziness: int) -> float:
    """The share of an SP's clusters that see a VPL cluster."""
    share = float(0.0)
    for f in range(fuzziness):
        bits = visibility[guided.cluster[f], cluster // 32] >> wp.uint32(cluster % 32)
        share += guided.weight[f] * float(bits & wp.uint32(1))
    return share


@cache
def draw_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws rays of SPs of F = `fuzziness` clusters each."""
    guides, guide_at, far_draw = guides_of(fuzziness), guide_at_of(fuzziness), far_draw_of(fuzziness)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def kernel(
        first: int,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        numbers: wp.array[int],
        count: wp.array[int],
        clusters: SpClusters,
        visibility: wp.array2d[wp.uint32],
        vpls: VplClusters,
        far: FarLight,
        settled: wp.array[int],
        seed: wp.array[int],
        number: int,
        indirect: Indirect,
        checks: Checks,
    ) -> None:
        """One thread a ray of pass `number`: draws to which member of which VPL cluster it goes."""
        index = first + wp.tid()
        place = index // CHECKS
        check = index % CHECKS
        checks.vpl[index] = -1
        if place >= count[0]:
            return
        sp = numbers[place]
        pixel = pixels[place]
        whole = indirect.near[sp] + indirect.far[sp]
        if whole <= 0.0 or (number == 0 and settled[pixel] == 1):
            return
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        own = wp.uint32(seed[0]) + wp.uint32(number) * PASS_SEED
        state = hashed(wp.uint32(pixel) ^ hashed(CHECK_KEY + wp.uint32(check) + wp.uint32(CHECKS) * own))
        pick = float(state) * TO_UNIT * whole - indirect.near[sp]
        guided = guides(clusters, sp, position, normal)
        believed = float(0.0)
        drawn = indirect.target[check, sp]
        if pick >= 0.0 or drawn < 0:
            guide = guide_at(guided, far.totals, wp.max(pick, 0.0))
            far_drawn = far_draw(position, normal, guided, visibility, vpls, far.near, far.mass, far.totals,
                                 LEAST_DOUBT, guide, state)  # fmt: skip
            drawn = far_drawn.cluster
            if drawn < 0:
                return
            state = far_drawn.state
            believed = far_drawn.believed
            whole *= far_drawn.scale
        else:
            believed = believed_share(guided, visibility, drawn, wp.static(fuzziness))
        target = member_of(position, normal, vpls, drawn, hashed(state))
        checks.vpl[index] = target.vpl
        checks.believed[index] = believed
        checks.share[index] = target.share * whole / doubt(believed)

    return kernel


@cache
def check_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        vpls: VplClusters,
        checks: Checks,
    ) -> None:
        """One thread a ray: by how much the SP's clusters are wrong about what it finds, over its density."""
        index = first + wp.tid()
        vpl = checks.vpl[index]
        if vpl < 0:
            return
        pixel = pixels[index // CHECKS]
        position = vpls.members.position[vpl]
        normal = vpls.members.normal[vpl]
        seen = float(0.0)
        if connect(scene, gbuffer.position[pixel], gbuffer.geometric[pixel], position, normal):
            seen = 1.0
        checks.share[index] = checks.share[index] * (seen - checks.believed[index])

    return kernel


@wp.kernel
def correction_kernel(first: int, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters, checks: Checks,
                      before: int, correction: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: the mean over its rays of what its irradiance lacks, taken into `correction` (pixel,).

    before: of how many such means that is the mean already.
    """
    place = first + wp.tid()
    if place >= count[0]:
        return
    mean = wp.vec3(0.0, 0.0, 0.0)
    for check in range(CHECKS):
        index = place * CHECKS + check
        vpl = checks.vpl[index]
        if vpl >= 0:
            flux = vpls.members.flux[vpl]
            mean += flux * (checks.share[index] / brightness(flux))
    mean = mean / float(CHECKS)
    pixel = pixels[place]
    if before > 0:
        mean = correction[pixel] + (mean - correction[pixel]) / float(before + 1)
    correction[pixel] = mean


class Correction:
    """Checks the light of up to `capacity` SPs; its arrays are allocated once.

    own (pixel,): what the irradiance of each SP lacks by its own rays, or has too much of, then negative [W/m²].
    """

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.device = device
        self.own = wp.zeros(capacity, dtype=wp.vec3, device=device)
        self._checks: Checks = allocate(Checks, CHECKS * capacity, device)

    def trace(
        self,
        scene: SceneData,
        gbuffer: GBuffer,
        points: ListedPoints,
        clusters: SpClusters,
        words: wp.array,
        vpls: VplClusters,
        far: FarLight,
        indirect: Indirect,
        settled: wp.array,
        seed: wp.array,
        passes: range = range(1),
    ) -> None:
        """Check the light of `points`, which were shaded by all these, once for each of `passes`, numbered from 0 on.

        Each takes its mean into that of those before. words: the visibility bits of `clusters`; settled (pixel,): 1
        for those that have no rays in pass 0; seed: (1,).
        """
        rays, checks, pixels = CHECKS * points.capacity, self._checks, points.pixels
        listed = pixels, points.numbers, points.count
        for number in passes:
            inputs: list[Any] = [gbuffer, *listed, clusters, words, vpls, far, settled, seed, number, indirect, checks]
            launch(draw_kernel(clusters.cluster.shape[0]), rays, inputs, self.device)
            launch(check_kernel(connection(scene)), rays, [scene, gbuffer, pixels, vpls, checks], self.device)
            inputs = [pixels, points.count, vpls, checks, number, self.own]
            launch(correction_kernel, points.capacity, inputs, self.device)

"""Rays from shading points themselves that correct what their clusters believe. Beyond the 2022 paper.

Fuzzy visibility is a control variate: an SP sends a few rays to VPL clusters, drawn in proportion to their light and
to how far its clusters may be wrong about them (gpu.indirect.far_field.visibility_weight). The difference between what
a ray finds and what the clusters believed estimates their error, and is right in the mean. It is zero where they are
right, so its noise is small, and neighbours on a surface share it. Rays end at members of VPL clusters, so that what
clustering VPLs does to penumbrae is corrected, too.
"""

from functools import cache, partial
from typing import Any

import warp as wp

from gpu.core.device import allocate, launch
from gpu.correction.vpl_sampling import cluster_pick_of, cluster_visibility_of, far_sample_of, member_of, sees_member_of
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connection
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ListedPoints
from gpu.indirect.far_field import MIN_VISIBILITY_WEIGHT, FarLight, visibility_weight
from gpu.indirect.fuzzy_shading import REGISTERS, guides_of
from gpu.indirect.irradiance import CHECKS, Indirect
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.form_factor import light_of
from gpu.vpl.vpl_clusters import VplClusters

CHECK_KEY = wp.constant(wp.uint32(0x5BD1E995))
# SPs that follow each other have steps of the golden ratio between their rays, as a share of 2³².
GOLDEN_STEP = wp.constant(wp.uint32(2654435769))
# Interpolated the seeds of several passes.
PASS_SEED = wp.constant(wp.uint32(0x3C6EF372))
# SPs that follow each other have a pass together, as the threads of a warp trace their rays.
RUN = wp.constant(32 // CHECKS)
ALL_PASSES = 1e3


@wp.struct
class CorrectionRays:
    """Rays of listed SPs, (place, check) flattened: those of one SP run side by side.

    vpl: that each goes to, −1 for none; believed: the share of the SP's clusters that see it; share: its light over its
    density [W/m²], and, once traced, times what the SP's clusters are wrong by.
    """

    vpl: wp.array[int]
    cluster_visibility: wp.array[float]
    share: wp.array[float]


@wp.func
def has_pass(place: int, number: int, passes: float, seed: int) -> bool:
    """Whether the SP at a place of a list has rays in pass `number`, where SPs have so many `passes` in the mean."""
    offset = hashed(PASS_SEED + wp.uint32(seed))
    part = float(wp.uint32(place // RUN) * GOLDEN_STEP + offset) * TO_UNIT
    return part < passes - float(number)


@cache
def draw_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws rays of SPs of F = `fuzziness` clusters each."""
    guides, pick_cluster, sample_far = guides_of(fuzziness), cluster_pick_of(fuzziness), far_sample_of(fuzziness)

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
        passes: wp.array[float],
        again: bool,
        indirect: Indirect,
        checks: CorrectionRays,
    ) -> None:
        """One thread a ray of pass `number`: draws to which member of which VPL cluster it goes.

        passes (1,): of an SP, in the mean; again: whether what is settled has rays, too. An SP's rays take equal shares
        of all light, and those of neighbours, who share what they find, other parts of these.
        """
        index = first + wp.tid()
        place = index // CHECKS
        check = index % CHECKS
        checks.vpl[index] = -1
        if place >= count[0] or not has_pass(place, number, passes[0], seed[0]):
            return
        sp = numbers[place]
        pixel = pixels[place]
        whole = indirect.near[sp] + indirect.far[sp]
        if whole <= 0.0 or (settled[pixel] == 1 and not again):
            return
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        own = wp.uint32(seed[0]) + wp.uint32(number) * PASS_SEED
        key = hashed(CHECK_KEY + wp.uint32(check) + wp.uint32(CHECKS) * own)
        state = hashed(wp.uint32(pixel) ^ key)
        step = float(wp.uint32(sp) * GOLDEN_STEP + key) * TO_UNIT
        u = (float(check) + step) / float(CHECKS) * whole - indirect.near[sp]
        guided = guides(clusters, sp, position, normal)
        cluster_visibility = float(0.0)
        drawn = indirect.target[check, sp]
        if u >= 0.0 or drawn < 0:
            guide = pick_cluster(guided, far.importance_cdf, float(state) * TO_UNIT * indirect.far[sp])
            if guide.cluster >= 0:
                on = wp.clamp(u / indirect.far[sp], 0.0, 1.0)
                guide.u = on * far.importance_cdf[far.importance_cdf.shape[0] - 1, guide.cluster]
            far_drawn = sample_far(position, normal, guided, visibility, vpls, far.near, far.importance,
            far.importance_cdf,
                                 MIN_VISIBILITY_WEIGHT, guide, state)  # fmt: skip
            drawn = far_drawn.cluster
            if drawn < 0:
                return
            state = far_drawn.state
            cluster_visibility = far_drawn.cluster_visibility
            whole *= far_drawn.scale
        else:
            cluster_visibility = cluster_visibility_of(guided, visibility, drawn, wp.static(fuzziness))
        target = member_of(position, normal, vpls, drawn, hashed(state))
        checks.vpl[index] = target.vpl
        checks.cluster_visibility[index] = cluster_visibility
        checks.share[index] = target.share * whole / visibility_weight(cluster_visibility)

    return kernel


@cache
def check_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.device_scene.rays.connected and connected_solid."""
    sees = sees_member_of(connect)

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        vpls: VplClusters,
        checks: CorrectionRays,
    ) -> None:
        """One thread a ray: by how much the SP's clusters are wrong about what it finds, over its density."""
        index = first + wp.tid()
        vpl = checks.vpl[index]
        if vpl < 0:
            return
        seen = float(0.0)
        if sees(scene, gbuffer, pixels[index // CHECKS], vpls, vpl):
            seen = 1.0
        checks.share[index] = checks.share[index] * (seen - checks.cluster_visibility[index])

    return kernel


@wp.kernel
def correction_kernel(first: int, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters, checks:
CorrectionRays,
                      seed: wp.array[int], number: int, passes: wp.array[float], means: wp.array[int],
                      correction: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: the mean over its rays of what its irradiance lacks, taken into `correction` (pixel,).

    means (pixel,): of how many passes that is the mean. number, passes: as in draw_kernel.
    """
    place = first + wp.tid()
    if place >= count[0] or not has_pass(place, number, passes[0], seed[0]):
        return
    mean = wp.vec3(0.0, 0.0, 0.0)
    for check in range(CHECKS):
        index = place * CHECKS + check
        vpl = checks.vpl[index]
        if vpl >= 0:
            mean += light_of(vpls, vpl, checks.share[index])
    mean = mean / float(CHECKS)
    pixel = pixels[place]
    before = wp.where(number > 0, means[pixel], 0)
    if before > 0:
        mean = correction[pixel] + (mean - correction[pixel]) / float(before + 1)
    means[pixel] = before + 1
    correction[pixel] = mean


class Correction:
    """CorrectionRays the light of up to `capacity` SPs; its arrays are allocated once.

    most: of the passes that may be wanted. own (pixel,): what the irradiance of each SP lacks by its own rays, or has
    too much of, then negative [W/m²].
    """

    def __init__(self, capacity: int, device: wp.Device, most: int = 1) -> None:
        self.device = device
        self.own = wp.zeros(capacity, dtype=wp.vec3, device=device)
        self._means = wp.zeros(capacity, dtype=int, device=device)
        self._checks: CorrectionRays = allocate(CorrectionRays, CHECKS * capacity, device)
        self._wanted = wp.ones(1, dtype=float, device=device)
        # Whether any SP has each of them. Graphs read that, and launch nothing for those that none has.
        self._has = wp.zeros(most, dtype=int, device=device)
        self._all = wp.full(1, ALL_PASSES, dtype=float, device=device)

    def use(self, passes: float) -> None:
        """Have so many passes of an SP in the mean, at least 1, where they are to be `as_wanted`."""
        self._wanted.fill_(passes)
        self._has.assign([int(number < passes) for number in range(len(self._has))])

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
        numbers: range = range(1),
        *,
        as_wanted: bool = False,
    ) -> None:
        """Check the light of `points`, which were shaded by all these, in passes of these `numbers`.

        Each takes its mean into that of those before, unless it is number 0. words: the visibility bits of `clusters`;
        settled (pixel,): 1 for those that have no rays, unless `numbers` begin later; seed: (1,). as_wanted: whether
        passes are left out beyond as many as were wanted (`use`).
        """
        rays, checks, pixels = CHECKS * points.capacity, self._checks, points.pixels
        listed = pixels, points.numbers, points.count
        passes, again = self._wanted if as_wanted else self._all, numbers.start > 0

        def run(number: int) -> None:
            by = clusters, words, vpls, far, settled, seed, number, passes, again
            inputs: list[Any] = [gbuffer, *listed, *by, indirect, checks]
            launch(draw_kernel(clusters.cluster.shape[0]), rays, inputs, self.device)
            launch(check_kernel(connection(scene)), rays, [scene, gbuffer, pixels, vpls, checks], self.device)
            inputs = [pixels, points.count, vpls, checks, seed, number, passes, self._means, self.own]
            launch(correction_kernel, points.capacity, inputs, self.device)

        for number in numbers:
            if as_wanted and number > 0:
                wp.capture_if(self._has[number : number + 1], partial(run, number))
            else:
                run(number)

"""Rays from shading points themselves that correct what their clusters believe. Beyond the 2022 paper.

Fuzzy visibility is a control variate: an SP sends a few rays to VPL clusters, drawn in proportion to their light and
to how far its clusters may be wrong about them (gpu.indirect.far_field.visibility_weight). The difference between what
a ray finds and what the clusters believed estimates their error, and is right in the mean. It is zero where they are
right, so its noise is small, and neighbours on a surface share it. Rays end at members of VPL clusters, so that what
clustering VPLs does to penumbrae is corrected, too.
"""

from dataclasses import dataclass
from functools import cache, partial

import warp as wp

from gpu.core.constants import GOLDEN_STEP
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.correction.vpl_sampling import VPL_SAMPLE_PARAMETERS, VplSampleParameters, vpl_sample_of
from gpu.device_scene.data import SceneData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints, ShadingPoints
from gpu.indirect.clustered_light import ClusteredLight
from gpu.indirect.far_field import visibility_weight
from gpu.indirect.fuzzy_shading import REGISTERS
from gpu.indirect.irradiance import CHECKS, Indirect
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.form_factor import light_of
from gpu.vpl.shadow_rays import NO_RAY, ShadowRays, arrival, colouring, shadow_rays, target_of, trace_shadow_rays
from gpu.vpl.vpl_clusters import VplClusters

CHECK_KEY = wp.constant(wp.uint32(0x5BD1E995))
# Between the seeds of several passes.
PASS_SEED = wp.constant(wp.uint32(0x3C6EF372))
# SPs that follow each other have a pass together, as the threads of a warp trace their rays.
RUN = wp.constant(32 // CHECKS)
# More than any frame has.
ALL_PASSES = 1e3


@wp.struct
@dataclass
class CorrectionParameters:
    """How much a few rays are believed.

    least_light: of what clusters tell, this share of which remains, whatever an SP's rays of one frame find. Where they
    leave less, a third to two thirds arrive; those of more frames are believed more.
    """

    least_light: float = 0.3


CORRECTION_PARAMETERS: CorrectionParameters = parameters(CorrectionParameters)


@wp.struct
class CorrectionPass:
    """A pass of rays, of which each SP that has it sends CHECKS.

    number: from 0; passes (1,): how many an SP has in the mean; seed: (1,); settled (pixel,): 1 for SPs that have rays
    only `again`, in passes after a first look.
    """

    number: int
    passes: wp.array[float]
    seed: wp.array[int]
    settled: wp.array[int]
    again: bool


@wp.func
def has_pass(place: int, this_pass: CorrectionPass) -> bool:
    """Whether the SP at a place of a list has rays in a pass."""
    offset = hashed(PASS_SEED + wp.uint32(this_pass.seed[0]))
    part = float(wp.uint32(place // RUN) * GOLDEN_STEP + offset) * TO_UNIT
    return part < this_pass.passes[0] - float(this_pass.number)


@cache
def correction_ray_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws rays of SPs of F = `fuzziness` clusters each."""
    sample_vpl = vpl_sample_of(fuzziness, weighted=True)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def correction_ray_kernel(
        first: int,
        gbuffer: GBuffer,
        points: PointList,
        known: ClusteredLight,
        this_pass: CorrectionPass,
        indirect: Indirect,
        rays: ShadowRays,
        limits: VplSampleParameters,
    ) -> None:
        """One thread a ray of a pass: draws to which member of which VPL cluster it goes.

        An SP's rays take equal shares of all light, and those of neighbours, who share what they find, other parts of
        these.
        """
        index = first + wp.tid()
        place = index // CHECKS
        check = index % CHECKS
        if place >= points.count[0]:
            return
        rays.vpl[index] = NO_RAY
        if not has_pass(place, this_pass):
            return
        sp = points.numbers[place]
        pixel = points.pixels[place]
        whole = indirect.near_importance[sp] + indirect.far_importance[sp]
        if whole <= 0.0 or (this_pass.settled[pixel] == 1 and not this_pass.again):
            return
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        own = wp.uint32(this_pass.seed[0]) + wp.uint32(this_pass.number) * PASS_SEED
        key = hashed(CHECK_KEY + wp.uint32(check) + wp.uint32(CHECKS) * own)
        state = hashed(wp.uint32(pixel) ^ key)
        step = float(wp.uint32(sp) * GOLDEN_STEP + key) * TO_UNIT
        u = (float(check) + step) / float(CHECKS) * whole - indirect.near_importance[sp]
        near = indirect.target[check, sp]
        if u >= 0.0:
            near = -1
        pick = wp.vec2(float(state) * TO_UNIT * indirect.far_importance[sp], u / indirect.far_importance[sp])
        sample = sample_vpl(position, normal, sp, known, near, pick, state, limits)
        if sample.vpl >= 0:
            rays.vpl[index] = sample.vpl
            rays.cluster_visibility[index] = sample.cluster_visibility
            weight = visibility_weight(sample.cluster_visibility)
            rays.share[index] = sample.share * (whole * sample.scale) / weight

    return correction_ray_kernel


@wp.kernel
def correction_kernel(first: int, points: PointList, vpls: VplClusters, rays: ShadowRays, this_pass: CorrectionPass,
                      means: wp.array[int], correction: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: the mean over its traced rays of what its irradiance lacks, taken into `correction` (pixel,).

    means (pixel,): of how many passes that is the mean.
    """
    place = first + wp.tid()
    if place >= points.count[0] or not has_pass(place, this_pass):
        return
    mean = wp.vec3(0.0, 0.0, 0.0)
    for check in range(CHECKS):
        index = place * CHECKS + check
        vpl = target_of(rays.vpl[index])
        if vpl != NO_RAY:
            wrong = arrival(rays.vpl[index]) - rays.cluster_visibility[index]
            mean += light_of(vpls, vpl, rays.share[index] * wrong)
            mean += wp.cw_mul(light_of(vpls, vpl, rays.share[index]), colouring(rays, index))
    mean = mean / float(CHECKS)
    pixel = points.pixels[place]
    before = wp.where(this_pass.number > 0, means[pixel], 0)
    if before > 0:
        mean = correction[pixel] + (mean - correction[pixel]) / float(before + 1)
    means[pixel] = before + 1
    correction[pixel] = mean


@wp.kernel
def bound_correction_kernel(first: int, points: PointList, irradiance: wp.array[wp.vec3], frames: wp.array[int],
                            chosen: CorrectionParameters, correction: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: its `correction` takes no more of `irradiance` than rays can tell of so many earlier `frames`.

    (pixel,) each.
    """
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    least = chosen.least_light / float(frames[pixel] + 1)
    correction[pixel] = wp.max(correction[pixel], irradiance[pixel] * (least - 1.0))


@dataclass(frozen=True)
class RayPasses:
    """Which passes of rays SPs have, by which `seed` (1,).

    settled (pixel,): 1 for SPs that have no rays, unless `numbers` begin later than 0; as_wanted: whether passes are
    left out beyond as many as were wanted (`Correction.use`).
    """

    seed: wp.array
    settled: wp.array
    numbers: range
    as_wanted: bool = False


class Correction:
    """Corrects the light of up to `capacity` SPs; its arrays are allocated once.

    most: of the passes that may be wanted; tinted: as of `shadow_rays`. own (pixel,): what the irradiance of each SP
    lacks by its own rays, or has too much of, then negative [W/m²]; rays: CHECKS of each.
    """

    def __init__(self, capacity: int, device: wp.Device, most: int = 1, *, tinted: bool = False) -> None:
        self.device = device
        self.own = wp.zeros(capacity, dtype=wp.vec3, device=device)
        self._means = wp.zeros(capacity, dtype=int, device=device)
        self.rays = shadow_rays(capacity, CHECKS, device, side_by_side=True, control_variate=True, tinted=tinted)
        self._wanted = wp.ones(1, dtype=float, device=device)
        # Whether any SP has each of them. Graphs read that, and launch nothing for those that none has.
        self._has = wp.zeros(most, dtype=int, device=device)
        self._all = wp.full(1, ALL_PASSES, dtype=float, device=device)

    def use(self, passes: float) -> None:
        """Have so many passes of an SP in the mean, at least 1, where they are to be `as_wanted`."""
        self._wanted.fill_(passes)
        self._has.assign([int(number < passes) for number in range(len(self._has))])

    def trace(self, scene: SceneData, gbuffer: GBuffer, points: ListedPoints, known: ClusteredLight,
              indirect: Indirect, passes: RayPasses) -> None:  # fmt: skip
        """Check the light of `points`, which were shaded by all these, in some `passes`.

        Each takes its mean into that of those before, unless it is number 0.
        """
        listed, rays = points.points, self.rays

        def run(number: int) -> None:
            one = CorrectionPass()
            one.number, one.again = number, passes.numbers.start > 0
            one.passes = self._wanted if passes.as_wanted else self._all
            one.seed, one.settled = passes.seed, passes.settled
            draw = correction_ray_kernel(known.clusters.cluster.shape[0])
            inputs = [gbuffer, listed, known, one, indirect, rays, VPL_SAMPLE_PARAMETERS]
            launch(draw, CHECKS * points.capacity, inputs, self.device)
            trace_shadow_rays(scene, gbuffer, listed, known.vpls, rays)
            inputs = [listed, known.vpls, rays, one, self._means, self.own]
            launch(correction_kernel, points.capacity, inputs, self.device)

        for number in passes.numbers:
            if passes.as_wanted and number > 0:
                wp.capture_if(self._has[number : number + 1], partial(run, number))
            else:
                run(number)

    def bound(self, points: ShadingPoints, irradiance: wp.array, frames: wp.array, correction: wp.array) -> None:
        """Have a shared `correction` leave some of the `irradiance` of `points`, less the more earlier `frames` their
        rays are of; (pixel,) each.

        Frames that are averaged are not bounded: their mean would be too large.
        """
        inputs = [points.points, irradiance, frames, CORRECTION_PARAMETERS, correction]
        launch(bound_correction_kernel, points.capacity, inputs, self.device)

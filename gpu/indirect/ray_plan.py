"""Which pairs of representatives of SP clusters and VPL clusters get visibility rays. Beyond the 2022 paper.

Pairs that face away from or lie behind each other get no ray: the representatives exchange no light.

Most others exchange little. A VPL cluster that sends a representative less than a 512th of all its light, if nothing
hid any, is weak there. Where little of that arrives, as around a lamp whose shade keeps it, all its light counts as
four times what does, which a ray to one cluster of each ARRIVAL_RAYS-th of them tells, chosen by its light. Of eight
neighbouring VPL clusters the weak ones share one ray, to the brightest of them; of 32, those eights whose weak ones
send less than a 512th together share one; the others have a ray each. What that can be wrong by at a representative: by
less than 1/512 of all its light for each pair, less than 7/512 for eight neighbours, and on the whole by no more than
the pairs without a ray of their own send. Shadows that begin between neighbours make some too bright and others too
dark, so that the sum is off by much less.
"""

from dataclasses import dataclass
from functools import cache

import warp as wp

from gpu.core.color import brightness
from gpu.core.intrinsics import bit_count, lowest_bit, room_in
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import made_for, ray_registers, specialisation
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance
from gpu.vpl.vpl_clusters import VplClusters

WORD_BITS = wp.constant(32)
EIGHT = wp.constant(8)
EIGHTS = WORD_BITS // EIGHT
# The sum is taken in parts, since there are few representatives for a GPU's threads.
PARTS = wp.constant(32)
# Rays that tell how much light arrives at a representative, each for as many of these parts; no more than there are.
ARRIVAL_RAYS = wp.constant(8)
LEAST_LIGHT = wp.constant(1.0e-30)
BELOW_ONE = wp.constant(0.99999994)
NO_LIGHT = wp.constant(-1.0)


@wp.struct
@dataclass
class RayPlanParameters:
    """weak_share: of a representative's light, were none hidden: a VPL cluster that sends less is weak. That light
    counts as `times_arriving` what arrives at most, and as least_share of itself at least: few rays may find nothing.
    """

    weak_share: float = 1.0 / 512.0
    times_arriving: float = 4.0
    least_share: float = 1.0 / 16.0


RAY_PLAN_PARAMETERS: RayPlanParameters = parameters(RayPlanParameters)


@wp.struct
class RayPlan:
    """What is planned for words of 32 VPL clusters at a run of new representatives, (word, place in it) flattened.

    traced: bits of the pairs that have a ray; shared: of those that take another's answer; leaders: whose, four
    numbers of eight bits, one for each eight; first_ray: where a word's rays begin in their list.
    """

    traced: wp.array[wp.uint32]
    shared: wp.array[wp.uint32]
    leaders: wp.array[wp.uint32]
    first_ray: wp.array[int]


@wp.struct
class Run:
    """New representatives whose pairs are planned and traced together: from `begin` in their order `most` at the most.

    number: of the run; words: of VPL clusters.
    """

    number: int
    begin: int
    most: int
    words: int


@wp.func
def length_of(run: Run, sps: SpClusters) -> int:
    """How many representatives a run has."""
    return wp.clamp(sps.fresh[0] - run.begin, 0, run.most)


@wp.func
def pair_light(p: wp.vec3, p_normal: wp.vec3, vpls: VplClusters, vpl: int) -> float:
    """Brightness that a VPL cluster sends a representative if nothing is between them, NO_LIGHT if it cannot.

    The cluster's normals fill a cone, so some members may reach what its representative does not; a surface's own
    plane is what it is.
    """
    disk = disk_at(vpls.disks, vpl)
    way = disk.position - p
    distance = wp.length(way)
    normal_cone_cos = vpls.normal_cone_cos[vpl]
    slack = wp.sqrt(wp.max(1.0 - normal_cone_cos * normal_cone_cos, 0.0)) * distance
    if wp.dot(way, disk.normal) >= slack or wp.dot(way, p_normal) <= 0.0:
        return NO_LIGHT
    return brightness(disk_irradiance(p, p_normal, disk))


@wp.func
def chance_of(number: int) -> float:
    """In [0, 1), as by chance."""
    return float(hashed(wp.uint32(number))) * TO_UNIT


@wp.func
def chance_left(chance: float, share: float) -> float:
    """What is uniform in [0, 1) again, as by chance, once `chance`, which was, has said whether it is below `share`."""
    below = chance / wp.max(share, LEAST_LIGHT)
    above = (chance - share) / wp.max(1.0 - share, LEAST_LIGHT)
    return wp.min(wp.where(chance < share, below, above), BELOW_ONE)


@wp.kernel(module="unique", module_options={"fast_math": True})
def pair_light_kernel(first: int, sps: SpClusters, vpls: VplClusters, parts: wp.array[float],
                      picks: wp.array[int]) -> None:  # fmt: skip
    """One thread a PARTS-th of the VPL clusters at one new representative: the sum of their light, and one of them that
    is chosen by it, −1 where there is none.

    parts, picks: (part, place in the SP clusters' order).
    """
    index = first + wp.tid()
    fresh = sps.fresh[0]
    if index >= PARTS * fresh:
        return
    sp = sps.order[index % fresh]
    vpl = index // fresh
    total = float(0.0)
    pick = int(-1)
    chance = chance_of(vpl * sps.position.shape[0] + sp)
    while vpl < vpls.count:
        light = wp.max(pair_light(sps.position[sp], sps.geometric_normal[sp], vpls, vpl), 0.0)
        total += light
        share = light / wp.max(total, LEAST_LIGHT)
        pick = wp.where(chance < share, vpl, pick)
        chance = chance_left(chance, share)
        vpl += PARTS
    parts[index] = total
    picks[index] = pick


@made_for("cutouts", "part_glass")
def arriving_light_kernel(features: SceneFeatures, see: wp.Function) -> wp.Kernel:
    """The kernel that traces with `see`, as gpu.indirect.visibility.visibility_ray_kernel."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", cuda_max_registers=ray_registers(features))
    def arriving_light_kernel(first: int, scene: SceneData, sps: SpClusters, vpls: VplClusters, parts: wp.array[float],
                              picks: wp.array[int], arriving: wp.array[float]) -> None:  # fmt: skip
        """One thread an ARRIVAL_RAYS-th of `pair_light_kernel`'s parts at one new representative: arriving (ray,
        place), their light where the pick of one of them, chosen by it, is seen, else 0.
        """
        if wp.static(features.part_glass or not features.cutouts):
            scene = specialise(scene)
        index = first + wp.tid()
        fresh = sps.fresh[0]
        if index >= ARRIVAL_RAYS * fresh:
            return
        place = index % fresh
        sp = sps.order[place]
        total = float(0.0)
        pick = int(-1)
        chance = chance_of(-1 - index)
        for part in range(index // fresh, PARTS, ARRIVAL_RAYS):
            light = parts[part * fresh + place]
            total += light
            share = light / wp.max(total, LEAST_LIGHT)
            pick = wp.where(chance < share, picks[part * fresh + place], pick)
            chance = chance_left(chance, share)
        arriving[index] = 0.0
        if pick < 0:
            return
        disk = disk_at(vpls.disks, pick)
        if see(scene, sps.position[sp], sps.geometric_normal[sp], disk.position, disk.normal):
            arriving[index] = total

    return arriving_light_kernel


@wp.kernel
def weak_light_kernel(first: int, sps: SpClusters, parts: wp.array[float], arriving: wp.array[float],
                      chosen: RayPlanParameters, weak: wp.array[float]) -> None:  # fmt: skip
    """One thread a new representative, in order: the light below which a VPL cluster is weak there, weak (place,).

    parts, arriving: of `pair_light_kernel` and `arriving_light_kernel`.
    """
    place = first + wp.tid()
    fresh = sps.fresh[0]
    if place >= fresh:
        return
    total = float(0.0)
    arrives = float(0.0)
    for part in range(PARTS):
        total += parts[part * fresh + place]
    for ray in range(ARRIVAL_RAYS):
        arrives += arriving[ray * fresh + place]
    weak[place] = chosen.weak_share * wp.clamp(chosen.times_arriving * arrives, chosen.least_share * total, total)


@cache
def ray_plan_kernel(facing_away: bool, shared_weak_rays: bool) -> wp.Kernel:
    """The kernel that plans the rays; facing_away, shared_weak_rays: whether such pairs have no rays of their own."""

    @wp.kernel(module="unique", module_options={"fast_math": True})
    def ray_plan_kernel(
        first: int,
        sps: SpClusters,
        vpls: VplClusters,
        run: Run,
        weak: wp.array[float],
        plan: RayPlan,
    ) -> None:
        """One thread a word at one new representative, neighbouring threads on neighbours in space.

        weak (place,): the light below which a VPL cluster is weak.
        """
        index = first + wp.tid()
        length = length_of(run, sps)
        if index >= run.words * length:
            return
        place = run.begin + index % length
        sp = sps.order[place]
        begin = WORD_BITS * (index // length)
        p = sps.position[sp]
        p_normal = sps.geometric_normal[sp]
        traced = wp.uint32(0)
        shared = wp.uint32(0)
        leaders = wp.uint32(0)
        # Of an eight's weak pairs, and of all eights whose weak pairs are weak together.
        eight_light = float(0.0)
        brightest = float(NO_LIGHT)
        leader = wp.uint32(0)
        pooled = wp.uint32(0)
        pool_brightest = float(NO_LIGHT)
        pool_leader = wp.uint32(0)
        members = wp.min(int(WORD_BITS), vpls.count - begin)
        for member in range(members):
            light = pair_light(p, p_normal, vpls, begin + member)
            bit = wp.uint32(1) << wp.uint32(member)
            if wp.static(shared_weak_rays) and light >= 0.0 and light < weak[place]:
                shared |= bit
                eight_light += light
                if light > brightest:
                    brightest = light
                    leader = wp.uint32(member)
            elif light >= 0.0 or not wp.static(facing_away):
                traced |= bit
            if brightest >= 0.0 and (member % EIGHT == EIGHT - 1 or member == members - 1):
                eight = wp.uint32(member // EIGHT)
                if eight_light >= weak[place]:
                    traced |= wp.uint32(1) << leader
                    leaders |= leader << (wp.uint32(EIGHT) * eight)
                else:
                    # The number 1 in an eight's place, to be times the leader's.
                    pooled |= wp.uint32(1) << (wp.uint32(EIGHT) * eight)
                    if brightest > pool_brightest:
                        pool_brightest = brightest
                        pool_leader = leader
                eight_light = 0.0
                brightest = NO_LIGHT
        if pooled != wp.uint32(0):
            traced |= wp.uint32(1) << pool_leader
            leaders |= pooled * pool_leader
        plan.traced[index] = traced
        plan.shared[index] = shared & ~traced
        plan.leaders[index] = leaders

    return ray_plan_kernel


@wp.kernel
def ray_list_kernel(first: int, sps: SpClusters, run: Run, plan: RayPlan, rays: wp.array[int], shared: wp.array[int],
                pairs: wp.array[int]) -> None:  # fmt: skip
    """One thread a word at a new representative: lists its rays, as 32 · index + bit, where there is room.

    rays, shared (run,): become how many are traced in this one, and how many take another's answer.
    """
    index = first + wp.tid()
    if index >= run.words * length_of(run, sps):
        return
    traced = plan.traced[index]
    ray = room_in(rays, run.number, bit_count(traced))
    plan.first_ray[index] = ray
    room_in(shared, run.number, bit_count(plan.shared[index]))
    while traced != wp.uint32(0):
        pairs[ray] = WORD_BITS * index + lowest_bit(traced)
        traced &= traced - wp.uint32(1)
        ray += 1


@wp.func
def with_shared(seen: wp.uint32, plan: RayPlan, index: int) -> wp.uint32:
    """The bits of a word whose rays have seen these, with those of the pairs that take another's answer."""
    leaders = plan.leaders[index]
    whole = seen
    for eight in range(EIGHTS):
        shift = wp.uint32(EIGHT * eight)
        leader = (leaders >> shift) & wp.uint32(WORD_BITS - 1)
        if ((seen >> leader) & wp.uint32(1)) == wp.uint32(1):
            whole |= plan.shared[index] & (wp.uint32(255) << shift)
    return whole

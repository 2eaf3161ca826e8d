"""Visibility between the representatives of SP clusters and VPL clusters, one bit a pair. Step 5 of the 2022 paper.

Pairs that face away from or lie behind each other get no ray: the representatives exchange no light.

Most others exchange little. Of eight neighbouring VPL clusters, those that send a representative less than a 512th of
all its light, if nothing hid any, share one ray, to the brightest of them; the others have a ray each. What that can
be wrong by at a representative: by less than 1/512 of all its light for each pair, less than 7/512 for eight
neighbours, and on the whole by no more than the pairs without a ray of their own send. Shadows that begin between
neighbours make some too bright and others too dark, so that the sum is off by much less.
"""

from functools import cache

import warp as wp

from gpu.carry import Table
from gpu.device import launch
from gpu.disk import disk_at
from gpu.grouping import running_total
from gpu.rays import connection, free_path
from gpu.resident import SceneData
from gpu.settings import EVERY_SKIP, Skips
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, disk_irradiance
from gpu.vpl_clusters import VplClusters

WORD_BITS = 32
GROUP = wp.constant(8)
GROUPS_A_WORD = WORD_BITS // int(GROUP)
# VPL clusters are taken in runs, so that what is planned for their pairs stays within bounded memory.
MAX_PAIRS = 1 << 25
# A group's plan: a bit for each pair with a ray, then one for each that takes the leader's answer, then the leader.
ALL = wp.constant(255)
SHARED_SHIFT = wp.constant(8)
LEADER_SHIFT = wp.constant(16)
# Threads that trace: each takes every so-manieth ray, since only the device knows how many there are.
TRACING_THREADS = 1 << 20
SPREAD = wp.constant(4)
# Of all light that a representative gets if nothing hides any: a VPL cluster that sends less is weak.
WEAK_SHARE = wp.constant(1.0 / 512.0)
# The sum is taken in parts, since there are few representatives for a GPU's threads.
PARTS = wp.constant(32)
NO_LIGHT = wp.constant(-1.0)


@wp.func
def pair_light(p: wp.vec3, p_normal: wp.vec3, vpls: VplClusters, vpl: int) -> float:
    """Brightness that a VPL cluster sends a representative if nothing is between them, NO_LIGHT if it cannot.

    The cluster's normals fill a cone, so some members may reach what its representative does not; a surface's own
    plane is what it is.
    """
    disk = disk_at(vpls.disks, vpl)
    way = disk.position - p
    distance = wp.length(way)
    cone = vpls.cone[vpl]
    slack = wp.sqrt(wp.max(1.0 - cone * cone, 0.0)) * distance
    if wp.dot(way, disk.normal) >= slack or wp.dot(way, p_normal) <= 0.0:
        return NO_LIGHT
    return brightness(disk_irradiance(p, p_normal, disk))


@wp.kernel(module="unique", module_options={"fast_math": True})
def part_kernel(first: int, sps: SpClusters, vpls: VplClusters, parts: wp.array[float]) -> None:
    """One thread a PARTS-th of the VPL clusters at one new representative: the sum of their light.

    parts: (part, place in the SP clusters' order).
    """
    index = first + wp.tid()
    fresh = sps.fresh[0]
    if index >= PARTS * fresh:
        return
    sp = sps.order[index % fresh]
    vpl = index // fresh
    total = float(0.0)
    while vpl < vpls.count:
        total += wp.max(pair_light(sps.position[sp], sps.geometric[sp], vpls, vpl), 0.0)
        vpl += PARTS
    parts[index] = total


@wp.kernel
def weak_kernel(first: int, sps: SpClusters, parts: wp.array[float], weak: wp.array[float]) -> None:
    """One thread a new representative, in order: the light below which a VPL cluster is weak there."""
    place = first + wp.tid()
    fresh = sps.fresh[0]
    if place >= fresh:
        return
    total = float(0.0)
    for part in range(PARTS):
        total += parts[part * fresh + place]
    weak[place] = WEAK_SHARE * total


@cache
def plan_kernel(facing_away: bool, weak_pairs: bool) -> wp.Kernel:
    """The kernel that plans the rays; facing_away, weak_pairs: whether such pairs have no rays of their own."""

    @wp.kernel(module="unique", module_options={"fast_math": True})
    def kernel(
        first: int,
        sps: SpClusters,
        vpls: VplClusters,
        first_vpl: int,
        groups: int,
        weak: wp.array[float],
        plans: wp.array[int],
        numbers: wp.array[int],
    ) -> None:
        """One thread a group of VPL clusters at one new representative, neighbouring threads on neighbours in space.

        plans, numbers: (group, place in the SP clusters' order), flattened: what pairs get rays, and how many do.
        groups: of VPL clusters.
        """
        index = first + wp.tid()
        fresh = sps.fresh[0]
        if index >= groups * fresh:
            numbers[index] = 0
            return
        place = index % fresh
        sp = sps.order[place]
        begin = first_vpl + GROUP * (index // fresh)
        p = sps.position[sp]
        p_normal = sps.geometric[sp]
        traced = int(0)
        shared = int(0)
        leader = int(0)
        brightest = float(NO_LIGHT)
        number = int(0)
        for member in range(wp.min(int(GROUP), vpls.count - begin)):
            light = pair_light(p, p_normal, vpls, begin + member)
            if wp.static(weak_pairs) and light >= 0.0 and light < weak[place]:
                shared = shared | (1 << member)
                if light > brightest:
                    brightest = light
                    leader = member
            elif light >= 0.0 or not wp.static(facing_away):
                traced = traced | (1 << member)
                number += 1
        if shared != 0:
            traced = traced | (1 << leader)
            shared = shared & ~(1 << leader)
            number += 1
        plans[index] = traced | (shared << SHARED_SHIFT) | (leader << LEADER_SHIFT)
        numbers[index] = number

    return kernel


@wp.kernel
def list_kernel(first: int, sps: SpClusters, groups: int, plans: wp.array[int], totals: wp.array[int],
                pairs: wp.array[int]) -> None:  # fmt: skip
    """One thread a group at a new representative: lists its rays, as GROUP · index + member, where those before end."""
    index = first + wp.tid()
    if index >= groups * sps.fresh[0]:
        return
    ray = int(0)
    if index > 0:
        ray = totals[index - 1]
    for member in range(GROUP):
        if ((plans[index] >> member) & 1) == 1:
            pairs[ray] = GROUP * index + member
            ray += 1


@cache
def trace_kernel(see: wp.Function) -> wp.Kernel:
    """The kernel that traces with `see`, one of gpu.rays.connected, unblocked and those of solid scenes."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        sps: SpClusters,
        vpls: VplClusters,
        first_vpl: int,
        groups: int,
        totals: wp.array[int],
        threads: int,
        pairs: wp.array[int],
    ) -> None:
        """One thread every threads-th ray of the list: its pair becomes 1 if it arrives, else 0.

        Where rays are few, only each SPREAD-th thread has one: fewer wait for each other.
        """
        thread = first + wp.tid()
        fresh = sps.fresh[0]
        if fresh == 0:
            return
        rays = totals[groups * fresh - 1]
        spread = wp.clamp(threads // wp.max(rays, 1), 1, SPREAD)
        if thread % spread != 0:
            return
        ray = thread // spread
        while ray < rays:
            index = pairs[ray] // GROUP
            sp = sps.order[index % fresh]
            vpl = first_vpl + GROUP * (index // fresh) + pairs[ray] % GROUP
            seen = int(0)
            disk = disk_at(vpls.disks, vpl)
            if see(scene, sps.position[sp], sps.geometric[sp], disk.position, disk.normal):
                seen = 1
            pairs[ray] = seen
            ray += (threads + spread - 1) // spread

    return kernel


@wp.kernel
def pack_kernel(first: int, sps: SpClusters, count: int, plans: wp.array[int], totals: wp.array[int],
                answers: wp.array[int], first_word: int, words: wp.array2d[wp.uint32], rays: wp.array[int],
                shared: wp.array[int]) -> None:  # fmt: skip
    """One thread a word: packs 32 VPL clusters' answers for one new representative, and counts them.

    count: words in this run; words: (sp cluster, word); rays, shared (sp clusters · words,): how many were traced and
    how many took another's.
    """
    index = first + wp.tid()
    fresh = sps.fresh[0]
    counted = first_word * words.shape[0] + index
    rays[counted] = 0
    shared[counted] = 0
    if index >= count * fresh:
        return
    place = index % fresh
    word = index // fresh
    bits = wp.uint32(0)
    traced = int(0)
    borrowed = int(0)
    for group in range(GROUPS_A_WORD):
        at = (word * GROUPS_A_WORD + group) * fresh + place
        plan = plans[at]
        ray = int(0)
        if at > 0:
            ray = totals[at - 1]
        seen = int(0)
        for pair in range(GROUP):
            if ((plan >> pair) & 1) == 1:
                seen = seen | (answers[ray] << pair)
                ray += 1
                traced += 1
            borrowed += (plan >> (pair + SHARED_SHIFT)) & 1
        if ((seen >> (plan >> LEADER_SHIFT)) & 1) == 1:
            seen = seen | ((plan >> SHARED_SHIFT) & ALL)
        bits |= wp.uint32(seen) << wp.uint32(GROUP * group)
    words[sps.order[place], first_word + word] = bits
    rays[counted] = traced
    shared[counted] = borrowed


class Visibility:
    """The bits of all pairs: words (sp cluster, word), bit b of word w is VPL cluster 32·w + b.

    A cluster that is not in use has the bits of whichever had its place before.

    rays, shared: counts that add up to the pairs that were traced, and to those that took another pair's answer.
    """

    def __init__(self, sp_count: int, vpl_count: int, device: wp.Device, skip: Skips = EVERY_SKIP) -> None:
        self.device, self._skip = device, skip
        self._sp_count = sp_count
        self._word_count = max(1, -(-vpl_count // WORD_BITS))
        self._run = min(self._word_count, max(1, MAX_PAIRS // (WORD_BITS * sp_count)))
        groups = self._run * GROUPS_A_WORD * sp_count
        self._plans = wp.zeros(groups, dtype=int, device=device)
        self._numbers = wp.zeros(groups, dtype=int, device=device)
        self._totals = wp.zeros(groups, dtype=int, device=device)
        self._pairs = wp.zeros(groups * int(GROUP), dtype=int, device=device)
        self._parts = wp.zeros(int(PARTS) * sp_count, dtype=float, device=device)
        self._weak = wp.zeros(sp_count, dtype=float, device=device)
        self.rays = wp.zeros(sp_count * self._word_count, dtype=int, device=device)
        self.shared = wp.zeros(sp_count * self._word_count, dtype=int, device=device)
        self.words = wp.zeros((sp_count, self._word_count), dtype=wp.uint32, device=device)

    @property
    def tables(self) -> list[Table]:
        """What is known of representatives: their bits."""
        return [Table(self.words)]

    def trace(self, scene: SceneData, sps: SpClusters, vpls: VplClusters) -> None:
        """Find what the new representatives of `sps` see; what others saw before stays."""
        count, device, skip = self._sp_count, self.device, self._skip
        plans, totals, pairs = self._plans, self._totals, self._pairs
        if skip.weak_pairs:
            launch(part_kernel, len(self._parts), [sps, vpls, self._parts], device)
            launch(weak_kernel, count, [sps, self._parts, self._weak], device)
        plan = plan_kernel(skip.facing_away, skip.weak_pairs)
        trace = trace_kernel(connection(scene) if skip.facing_away else free_path(scene))
        for first_word in range(0, self._word_count, self._run):
            words = min(self._run, self._word_count - first_word)
            groups, first_vpl = words * GROUPS_A_WORD, first_word * WORD_BITS
            launch(plan, groups * count, [sps, vpls, first_vpl, groups, self._weak, plans, self._numbers], device)
            running_total(self._numbers, totals)
            launch(list_kernel, groups * count, [sps, groups, plans, totals, pairs], device)
            threads = min(TRACING_THREADS, groups * count * int(GROUP))
            inputs = [scene, sps, vpls, first_vpl, groups, totals, threads, pairs]
            launch(trace, threads, inputs, device)
            inputs = [sps, words, plans, totals, pairs, first_word, self.words, self.rays, self.shared]
            launch(pack_kernel, words * count, inputs, device)

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

from gpu.device import launch
from gpu.rays import connection, free_path
from gpu.resident import SceneData
from gpu.settings import EVERY_SKIP, Skips
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, disk_irradiance
from gpu.vpl_clusters import VplClusters

WORD_BITS = 32
# VPL clusters are taken in runs, so that the unpacked answers stay within the cache's reach and bounded memory.
MAX_UNPACKED_BYTES = 64 << 20
# An answer's byte: whether a ray was traced, whether it arrived, or else whose answer of its group counts.
TRACED = wp.constant(1)
SEEN = wp.constant(2)
SHARED = wp.constant(4)
LEADER_SHIFT = wp.constant(4)
GROUP = wp.constant(8)
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
    way = vpls.position[vpl] - p
    distance = wp.length(way)
    cone = vpls.cone[vpl]
    slack = wp.sqrt(wp.max(1.0 - cone * cone, 0.0)) * distance
    if wp.dot(way, vpls.normal[vpl]) >= slack or wp.dot(way, p_normal) <= 0.0:
        return NO_LIGHT
    return brightness(disk_irradiance(p, p_normal, vpls, vpl))


@wp.kernel
def part_kernel(first: int, sps: SpClusters, sp_count: int, vpls: VplClusters, parts: wp.array[float]) -> None:
    """One thread a PARTS-th of the VPL clusters at one representative: the sum of their light. parts: (part, sp)."""
    index = first + wp.tid()
    sp = index % sp_count
    vpl = index // sp_count
    total = float(0.0)
    if sps.used[sp] == 1:
        while vpl < vpls.count:
            total += wp.max(pair_light(sps.position[sp], sps.geometric[sp], vpls, vpl), 0.0)
            vpl += PARTS
    parts[index] = total


@wp.kernel
def weak_kernel(first: int, parts: wp.array[float], sp_count: int, weak: wp.array[float]) -> None:
    """One thread a representative: the light below which a VPL cluster is weak there."""
    sp = first + wp.tid()
    total = float(0.0)
    for part in range(PARTS):
        total += parts[part * sp_count + sp]
    weak[sp] = WEAK_SHARE * total


@cache
def visibility_kernel(see: wp.Function, facing_away: bool, weak_pairs: bool) -> wp.Kernel:
    """The kernel that traces with `see` of gpu.rays; facing_away, weak_pairs: whether these have no rays of their own.

    see: one of connected and connected_solid with `facing_away`, else of unblocked and unblocked_solid.
    """

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        sps: SpClusters,
        sp_count: int,
        vpls: VplClusters,
        first_vpl: int,
        weak: wp.array[float],
        answers: wp.array[wp.uint8],
    ) -> None:
        """One thread a pair, neighbouring threads on neighbouring SP clusters: whether they see each other.

        answers: (vpl cluster − first_vpl, place in the SP clusters' order), flattened: a byte of the flags above.
        """
        pair = first + wp.tid()
        sp = sps.order[pair % sp_count]
        vpl = first_vpl + pair // sp_count
        answers[pair] = wp.uint8(0)
        if vpl >= vpls.count or sps.used[sp] == 0:
            return
        p = sps.position[sp]
        p_normal = sps.geometric[sp]
        light = pair_light(p, p_normal, vpls, vpl)
        if wp.static(facing_away) and light < 0.0:
            return
        if wp.static(weak_pairs) and light >= 0.0 and light < weak[sp]:
            leader = int(vpl)
            begin = vpl - vpl % GROUP
            brightest = float(NO_LIGHT)
            for other in range(begin, wp.min(begin + GROUP, vpls.count)):
                other_light = pair_light(p, p_normal, vpls, other)
                if other_light < weak[sp] and other_light > brightest:
                    brightest = other_light
                    leader = other
            if leader != vpl:
                answers[pair] = wp.uint8(SHARED | ((leader - begin) << LEADER_SHIFT))
                return
        answer = TRACED
        if see(scene, p, p_normal, vpls.position[vpl], vpls.normal[vpl]):
            answer = TRACED | SEEN
        answers[pair] = wp.uint8(answer)

    return kernel


@wp.kernel
def pack_kernel(first: int, answers: wp.array[wp.uint8], sp_count: int, first_word: int, order: wp.array[int],
                words: wp.array2d[wp.uint32], rays: wp.array[int], shared: wp.array[int]) -> None:  # fmt: skip
    """One thread a word: packs 32 VPL clusters' answers for one SP cluster, and counts them.

    words: (sp cluster, word); rays, shared: how many were traced and how many took another's, flattened word by word.
    """
    index = first + wp.tid()
    place = index % sp_count
    word = index // sp_count
    bits = wp.uint32(0)
    traced = int(0)
    borrowed = int(0)
    for bit in range(32):
        answer = int(answers[(word * 32 + bit) * sp_count + place])
        if (answer & SHARED) != 0:
            borrowed += 1
            leader = bit - bit % GROUP + (answer >> LEADER_SHIFT)
            answer = int(answers[(word * 32 + leader) * sp_count + place]) & SEEN
        traced += answer & TRACED
        bits |= wp.uint32((answer & SEEN) // SEEN) << wp.uint32(bit)
    words[order[place], first_word + word] = bits
    rays[first_word * sp_count + index] = traced
    shared[first_word * sp_count + index] = borrowed


class Visibility:
    """The bits of all pairs: words (sp cluster, word), bit b of word w is VPL cluster 32·w + b.

    rays, shared: counts that add up to the pairs that were traced, and to those that took another pair's answer.
    """

    def __init__(self, sp_count: int, vpl_count: int, device: wp.Device, skip: Skips = EVERY_SKIP) -> None:
        self.device, self._skip = device, skip
        self._sp_count = sp_count
        self._word_count = max(1, -(-vpl_count // WORD_BITS))
        self._run = min(self._word_count, max(1, MAX_UNPACKED_BYTES // (WORD_BITS * sp_count)))
        self._answers = wp.zeros(self._run * WORD_BITS * sp_count, dtype=wp.uint8, device=device)
        self._parts = wp.zeros(int(PARTS) * sp_count, dtype=float, device=device)
        self._weak = wp.zeros(sp_count, dtype=float, device=device)
        self.rays = wp.zeros(sp_count * self._word_count, dtype=int, device=device)
        self.shared = wp.zeros(sp_count * self._word_count, dtype=int, device=device)
        self.words = wp.zeros((sp_count, self._word_count), dtype=wp.uint32, device=device)

    def trace(self, scene: SceneData, sps: SpClusters, vpls: VplClusters) -> None:
        """Find which representatives see each other."""
        count, device, skip = self._sp_count, self.device, self._skip
        if skip.weak_pairs:
            launch(part_kernel, len(self._parts), [sps, count, vpls, self._parts], device)
            launch(weak_kernel, count, [self._parts, count, self._weak], device)
        see = connection(scene) if skip.facing_away else free_path(scene)
        kernel = visibility_kernel(see, skip.facing_away, skip.weak_pairs)
        for first_word in range(0, self._word_count, self._run):
            words = min(self._run, self._word_count - first_word)
            inputs = [scene, sps, count, vpls, first_word * WORD_BITS, self._weak, self._answers]
            launch(kernel, words * WORD_BITS * count, inputs, device)
            inputs = [self._answers, count, first_word, sps.order, self.words, self.rays, self.shared]
            launch(pack_kernel, words * count, inputs, device)

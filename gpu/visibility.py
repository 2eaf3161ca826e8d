"""Visibility between the representatives of SP clusters and VPL clusters, one bit a pair. Step 5 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.device import launch
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sp_clusters import SpClusters
from gpu.vpl_clusters import VplClusters

WORD_BITS = 32
# VPL clusters are taken in runs, so that the unpacked answers stay within the cache's reach and bounded memory.
MAX_UNPACKED_BYTES = 64 << 20
TRACED = wp.constant(1)
SEEN = wp.constant(2)


@wp.func
def may_connect(p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3, q_cone: float) -> bool:
    """Whether light can leave a VPL cluster at `q` towards `p`, by their normals alone.

    q_cone: cosine of the half angle that the cluster's normals fill; the SP's side is judged by its own plane.
    """
    way = p - q
    distance = wp.length(way)
    slack = wp.sqrt(wp.max(1.0 - q_cone * q_cone, 0.0)) * distance
    return wp.dot(way, q_normal) > -slack and wp.dot(way, p_normal) < 0.0


@cache
def visibility_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        sps: SpClusters,
        sp_count: int,
        vpls: VplClusters,
        first_vpl: int,
        visible: wp.array[wp.uint8],
    ) -> None:
        """One thread a pair, neighbouring threads on neighbouring SP clusters: whether they see each other.

        visible: (vpl cluster − first_vpl, sp cluster), flattened: TRACED where a ray was needed, plus SEEN.
        """
        pair = first + wp.tid()
        sp = pair % sp_count
        vpl = first_vpl + pair // sp_count
        answer = wp.uint8(0)
        if vpl < vpls.count and sps.used[sp] == 1:
            p = sps.position[sp]
            p_normal = sps.geometric[sp]
            q = vpls.position[vpl]
            q_normal = vpls.normal[vpl]
            if may_connect(p, p_normal, q, q_normal, vpls.cone[vpl]):
                answer = wp.uint8(TRACED)
                if connect(scene, p, p_normal, q, q_normal):
                    answer = wp.uint8(TRACED + SEEN)
        visible[pair] = answer

    return kernel


@wp.kernel
def pack_kernel(first: int, visible: wp.array[wp.uint8], sp_count: int, first_word: int,
                words: wp.array2d[wp.uint32], rays: wp.array[int]) -> None:  # fmt: skip
    """One thread a word: packs 32 VPL clusters' answers for one SP cluster, and counts the rays they took.

    words: (sp cluster, word); rays: the same, flattened word by word.
    """
    index = first + wp.tid()
    sp = index % sp_count
    word = index // sp_count
    bits = wp.uint32(0)
    traced = int(0)
    for bit in range(32):
        answer = int(visible[(word * 32 + bit) * sp_count + sp])
        traced += answer & TRACED
        bits |= wp.uint32(answer >> 1) << wp.uint32(bit)
    words[sp, first_word + word] = bits
    rays[first_word * sp_count + index] = traced


class Visibility:
    """The bits of all pairs: words (sp cluster, word), bit b of word w is VPL cluster 32·w + b; rays: taken."""

    def __init__(self, sp_count: int, vpl_count: int, device: wp.Device) -> None:
        self.device = device
        self._sp_count = sp_count
        self._word_count = max(1, -(-vpl_count // WORD_BITS))
        self._run = min(self._word_count, max(1, MAX_UNPACKED_BYTES // (WORD_BITS * sp_count)))
        self._visible = wp.zeros(self._run * WORD_BITS * sp_count, dtype=wp.uint8, device=device)
        self.rays = wp.zeros(sp_count * self._word_count, dtype=int, device=device)
        self.words = wp.zeros((sp_count, self._word_count), dtype=wp.uint32, device=device)

    def trace(self, scene: SceneData, sps: SpClusters, vpls: VplClusters) -> None:
        """One any-hit ray for each pair that can exchange light."""
        for first_word in range(0, self._word_count, self._run):
            words = min(self._run, self._word_count - first_word)
            pairs = words * WORD_BITS * self._sp_count
            inputs = [scene, sps, self._sp_count, vpls, first_word * WORD_BITS, self._visible]
            launch(visibility_kernel(connection(scene)), pairs, inputs, self.device)
            inputs = [self._visible, self._sp_count, first_word, self.words, self.rays]
            launch(pack_kernel, words * self._sp_count, inputs, self.device)

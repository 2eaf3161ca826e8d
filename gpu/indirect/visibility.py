"""Visibility between the representatives of SP clusters and VPL clusters, one bit a pair. Step 5 of the 2022 paper.

gpu.indirect.ray_plan tells which pairs have rays of their own.
"""

from copy import copy

import warp as wp

from gpu.core.device import BLOCK, FEW_BLOCKS, MOST_BLOCKS, allocate, launch, launch_together
from gpu.core.intrinsics import lowest_bit
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import connection, free_path
from gpu.device_scene.specialisation import cutouts_of, made_for, ray_registers, specialisation
from gpu.indirect.ray_plan import (
    ARRIVAL_RAYS,
    PARTS,
    RAY_PLAN_PARAMETERS,
    WORD_BITS,
    RayPlan,
    RayPlanParameters,
    Run,
    arriving_light_kernel,
    length_of,
    pair_light_kernel,
    ray_list_kernel,
    ray_plan_kernel,
    weak_light_kernel,
    with_shared,
)
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.disk_light import disk_at
from gpu.vpl.vpl_clusters import VplClusters

# New representatives are taken in runs, so that what is planned for their pairs stays within bounded memory.
MAX_PAIRS = 1 << 26
ALL_BITS = 0xFFFFFFFF
# Threads for each ray where there are few rays, at most; what rays find does not depend on it.
SPREAD = wp.constant(4)


@made_for("cutouts", "part_glass")
def visibility_ray_kernel(features: SceneFeatures, see: wp.Function) -> wp.Kernel:
    """The kernel that traces with `see`, one of gpu.device_scene.rays.connected, unblocked and those of solid
    scenes.
    """
    specialise = specialisation(features)

    @wp.kernel(module="unique", cuda_max_registers=ray_registers(features))
    def visibility_ray_kernel(
        first: int,
        scene: SceneData,
        sps: SpClusters,
        vpls: VplClusters,
        run: Run,
        rays: wp.array[int],
        threads: int,
        pairs: wp.array[int],
    ) -> None:
        """One thread every threads-th of the run's `rays` (run,): its pair becomes 1 if it arrives, else 0.

        Where rays are few, only each SPREAD-th thread has one: fewer wait for each other. pairs (ray,): which pair each
        is, of gpu.indirect.ray_plan.
        """
        if wp.static(features.part_glass or not features.cutouts):
            scene = specialise(scene)
        thread = first + wp.tid()
        length = length_of(run, sps)
        count = rays[run.number]
        spread = wp.clamp(threads // wp.max(count, 1), 1, SPREAD)
        if thread % spread != 0:
            return
        ray = thread // spread
        while ray < count:
            index = pairs[ray] // WORD_BITS
            sp = sps.order[run.begin + index % length]
            vpl = WORD_BITS * (index // length) + pairs[ray] % WORD_BITS
            seen = int(0)
            disk = disk_at(vpls.disks, vpl)
            if see(scene, sps.position[sp], sps.geometric_normal[sp], disk.position, disk.normal):
                seen = 1
            pairs[ray] = seen
            ray += (threads + spread - 1) // spread

    return visibility_ray_kernel


@wp.kernel
def visibility_word_kernel(first: int, sps: SpClusters, run: Run, plan: RayPlan, answers: wp.array[int],
                words: wp.array2d[wp.uint32]) -> None:  # fmt: skip
    """One thread a word: packs 32 VPL clusters' answers for one new representative. words: (sp cluster, word)."""
    index = first + wp.tid()
    length = length_of(run, sps)
    if index >= run.words * length:
        return
    ray = plan.first_ray[index]
    seen = wp.uint32(0)
    traced = plan.traced[index]
    while traced != wp.uint32(0):
        seen |= wp.uint32(answers[ray]) << wp.uint32(lowest_bit(traced))
        traced &= traced - wp.uint32(1)
        ray += 1
    words[sps.order[run.begin + index % length], index // length] = with_shared(seen, plan, index)


class Visibility:
    """The bits of all pairs: words (sp cluster, word), bit b of word w is VPL cluster 32·w + b.

    A cluster that is not in use has the bits of whichever had its place before.

    rays, shared (run,): how many pairs were traced, and how many took another pair's answer. facing_away,
    shared_weak_rays: whether pairs that exchange no light have no rays, and weak pairs share theirs.
    """

    def __init__(self, sp_count: int, vpl_count: int, device: wp.Device, *, facing_away: bool = True,
                 shared_weak_rays: bool = True,
                 chosen: RayPlanParameters = RAY_PLAN_PARAMETERS) -> None:  # fmt: skip
        self.device, self._facing_away, self._shared_weak_rays = device, facing_away, shared_weak_rays
        self._sp_count, self._chosen = sp_count, chosen
        self._word_count = max(1, -(-vpl_count // int(WORD_BITS)))
        self._run = min(sp_count, max(1, MAX_PAIRS // (int(WORD_BITS) * self._word_count)))
        words = self._run * self._word_count
        self._plan: RayPlan = allocate(RayPlan, words, device)
        self._pairs = wp.zeros(words * int(WORD_BITS), dtype=int, device=device)
        self._parts = wp.zeros(int(PARTS) * sp_count, dtype=float, device=device)
        self._arriving = wp.zeros(int(ARRIVAL_RAYS) * sp_count, dtype=float, device=device)
        self._picks = wp.zeros(len(self._parts), dtype=int, device=device)
        self._weak = wp.zeros(sp_count, dtype=float, device=device)
        runs = -(-sp_count // self._run)
        self._counts = wp.zeros(2 * runs, dtype=int, device=device)
        self.rays, self.shared = self._counts[:runs], self._counts[runs:]
        self.words = wp.zeros((sp_count, self._word_count), dtype=wp.uint32, device=device)

    def for_another_viewer(self) -> "Visibility":
        """One with bits of its own; both share what a trace only works with, so they trace one after the other."""
        other = copy(self)
        other.words = wp.zeros_like(self.words)
        return other

    def see_all(self) -> None:
        """Have every representative see every VPL cluster, without a ray."""
        self.words.fill_(ALL_BITS)
        self._counts.zero_()

    def trace(self, scene: SceneData, sps: SpClusters, vpls: VplClusters) -> None:
        """Find what the new representatives of `sps` see; what others saw before stays.

        Only the device knows how many are new, so all runs are launched: those after the first are seldom needed. Of
        the threads that trace each takes every so-manieth ray.
        """
        count, device, plan, pairs = self._sp_count, self.device, self._plan, self._pairs
        has = cutouts_of(scene)
        if self._shared_weak_rays:
            launch(pair_light_kernel, len(self._parts), [sps, vpls, self._parts, self._picks], device)
            inputs = [scene, sps, vpls, self._parts, self._picks, self._arriving]
            launch(arriving_light_kernel(has, connection(scene)), len(self._arriving), inputs, device)
            launch(weak_light_kernel, count, [sps, self._parts, self._arriving, self._chosen, self._weak], device)
        plans = ray_plan_kernel(self._facing_away, self._shared_weak_rays)
        trace = visibility_ray_kernel(has, connection(scene) if self._facing_away else free_path(scene))
        words = len(plan.traced)
        self._counts.zero_()
        for number, begin in enumerate(range(0, count, self._run)):
            run = Run()
            run.number, run.begin, run.most, run.words = number, begin, self._run, self._word_count
            blocks = FEW_BLOCKS if number else MOST_BLOCKS
            threads = min(BLOCK * blocks, len(pairs))
            launch(plans, words, [sps, vpls, run, self._weak, plan], device, blocks)
            launch_together(ray_list_kernel, words, [sps, run, plan, self.rays, self.shared, pairs], device, blocks)
            launch(trace, threads, [scene, sps, vpls, run, self.rays, threads, pairs], device, blocks)
            launch(visibility_word_kernel, words, [sps, run, plan, pairs, self.words], device, blocks)

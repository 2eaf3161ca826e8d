"""Rays from shading points themselves, to see whether their clusters told the truth. Beyond the 2022 paper.

Each SP sends one ray towards light that its clusters see, drawn in proportion to what it should get of it. Where
that is stopped, more are sent: the share of them that is stopped estimates by how much the SP is too bright.
"""

from functools import cache
from typing import Any

import warp as wp

from gpu.device import launch
from gpu.gbuffer import GBuffer
from gpu.grouping import running_total
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import CHECKS, Indirect
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, disk_irradiance
from gpu.visibility import Visibility
from gpu.vpl_clusters import VplClusters

# Of all SPs, at most this share has its stopped first ray confirmed by others.
CONFIRMED_SHARE = 0.2
CHECK_KEY = wp.constant(wp.uint32(0x5BD1E995))


@wp.func
def target_in(word: int, sp: int, position: wp.vec3, normal: wp.vec3, clusters: SpClusters,
              visibility: wp.array2d[wp.uint32], vpls: VplClusters, state: wp.uint32) -> int:  # fmt: skip
    """A VPL cluster of `word`, drawn in proportion to the light that the SP is believed to get of it, or −1."""
    target = int(-1)
    total = float(0.0)
    for bit in range(32):
        share = float(0.0)
        for f in range(clusters.cluster.shape[0]):
            answer = (visibility[clusters.cluster[f, sp], word] >> wp.uint32(bit)) & wp.uint32(1)
            share += clusters.weight[f, sp] * float(answer)
        if share > 0.0:
            amount = share * brightness(disk_irradiance(position, normal, vpls, 32 * word + bit))
            total += amount
            state = hashed(state)
            if float(state) * TO_UNIT * total < amount:
                target = 32 * word + bit
    return target


@wp.kernel
def draw_kernel(first: int, gbuffer: GBuffer, sps: wp.array[int], listed: wp.array[int], count: wp.array[int],
                capacity: int, check: int, clusters: SpClusters, visibility: wp.array2d[wp.uint32],
                vpls: VplClusters, indirect: Indirect, targets: wp.array[int]) -> None:  # fmt: skip
    """One thread a ray: draws the VPL cluster that it goes to, among those that its SP's clusters see.

    listed (place,): which SPs; all, in order, for ray 0. targets: (ray − check, place), flattened: VPL cluster or −1.
    """
    index = first + wp.tid()
    targets[index] = -1
    place = index % capacity
    if place >= count[0]:
        return
    number = check + index // capacity
    sp = place
    if number > 0:
        sp = listed[place]
    pixel = sps[sp]
    state = hashed(wp.uint32(pixel) ^ hashed(CHECK_KEY + wp.uint32(number)))
    word = indirect.word[number, sp]
    targets[index] = target_in(
        word, sp, gbuffer.position[pixel], gbuffer.normal[pixel], clusters, visibility, vpls, state
    )


@cache
def check_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        sps: wp.array[int],
        listed: wp.array[int],
        capacity: int,
        check: int,
        vpls: VplClusters,
        targets: wp.array[int],
    ) -> None:
        """One thread a ray of `draw_kernel`: its target becomes −1 when it arrives, and stays when it is stopped."""
        index = first + wp.tid()
        vpl = targets[index]
        if vpl < 0:
            return
        sp = index % capacity
        if check > 0:
            sp = listed[sp]
        pixel = sps[sp]
        if connect(scene, gbuffer.position[pixel], gbuffer.geometric[pixel], vpls.position[vpl], vpls.normal[vpl]):
            targets[index] = -1

    return kernel


@wp.kernel
def first_result_kernel(first: int, targets: wp.array[int], stopped: wp.array[float], flags: wp.array[int]) -> None:
    """One thread an SP: what its first ray found. stopped (sp,): 1 or 0; flags (sp,): the same, for the list."""
    sp = first + wp.tid()
    flags[sp] = int(targets[sp] >= 0)
    stopped[sp] = float(flags[sp])


@wp.kernel
def other_result_kernel(first: int, targets: wp.array[int], listed: wp.array[int], count: wp.array[int],
                        stopped: wp.array[float]) -> None:  # fmt: skip
    """One thread a listed SP, whose first ray was stopped: the share of all its rays that was."""
    place = first + wp.tid()
    if place >= count[0]:
        return
    number = float(1.0)
    for check in range(CHECKS - 1):
        if targets[check * listed.shape[0] + place] >= 0:
            number += 1.0
    stopped[listed[place]] = number / float(CHECKS)


@wp.kernel
def list_kernel(first: int, flags: wp.array[int], totals: wp.array[int], listed: wp.array[int],
                count: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: lists the flagged ones in their order, as many as `listed` holds; totals: sums of the flags."""
    sp = first + wp.tid()
    place = totals[sp] - 1
    if flags[sp] == 1 and place < listed.shape[0]:
        listed[place] = sp
    if sp == flags.shape[0] - 1:
        count[0] = wp.min(totals[sp], listed.shape[0])


class ClusterCheck:
    """Checks the light of up to `capacity` SPs; after `run`, `stopped` (sp,) is the share of an SP's rays that was."""

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.device = device
        listed = max(1, int(capacity * CONFIRMED_SHARE))
        self.stopped = wp.zeros(capacity, dtype=float, device=device)
        self._flags = wp.zeros(capacity, dtype=int, device=device)
        self._totals = wp.zeros(capacity, dtype=int, device=device)
        self._targets = wp.zeros(max(capacity, (CHECKS - 1) * listed), dtype=int, device=device)
        self._listed = wp.zeros(listed, dtype=int, device=device)
        self._list_count = wp.zeros(1, dtype=int, device=device)

    def run(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters,
            visibility: Visibility, vpls: VplClusters, indirect: Indirect) -> None:  # fmt: skip
        """Send the rays: one for each of `sps`, and the others for those whose first was stopped."""
        device = self.device
        clustering: list[Any] = [clusters, visibility.words, vpls, indirect, self._targets]
        check = check_kernel(connection(scene))
        points: list[Any] = [gbuffer, sps.pixels, self._listed]
        launch(draw_kernel, sps.capacity, [*points, sps.count, sps.capacity, 0, *clustering], device)
        launch(check, sps.capacity, [scene, *points, sps.capacity, 0, vpls, self._targets], device)
        launch(first_result_kernel, sps.capacity, [self._targets, self.stopped, self._flags], device)
        running_total(self._flags, self._totals)
        inputs = [self._flags, self._totals, self._listed, self._list_count]
        launch(list_kernel, sps.capacity, inputs, device)
        capacity = len(self._listed)
        rays = (CHECKS - 1) * capacity
        launch(draw_kernel, rays, [*points, self._list_count, capacity, 1, *clustering], device)
        launch(check, rays, [scene, *points, capacity, 1, vpls, self._targets], device)
        inputs = [self._targets, self._listed, self._list_count, self.stopped]
        launch(other_result_kernel, capacity, inputs, device)

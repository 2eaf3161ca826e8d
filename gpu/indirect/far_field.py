"""Light of far VPL clusters, summed once for each representative of shading points. Beyond the 2022 paper.

From afar a VPL cluster lights neighbouring SPs alike: what a representative gets of all of them, and how that changes
with place and direction, tells what its SPs get (G. Ward and P. Heckbert, Irradiance Gradients, 1992). Only VPL
clusters that are near a representative, in its spacings, are shaded SP by SP.
"""

from copy import copy
from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import PI
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import bits_of_all, float_sum, lanes_of, lowest_bit, vector_sum
from gpu.core.parameters import parameters
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.disk_light import Disk, disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened, is_subcluster_opened
from gpu.vpl.group_sampling import PARTS, GroupTable, group_table, groups_a_part
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters, is_behind, member_disk, out_of_reach

# Parts' sums are read so many at a time, before any is written: a thread would wait for each else.
CHUNK = 8
Chunk = wp.types.vector(length=CHUNK, dtype=float)


@dataclass(frozen=True)
class VisibilityWeightParameters:
    """hidden: how wrong clusters may be that all agree that light is hidden, relative to such that all see it. Compiled
    in: the innermost loop of shading has it.
    """

    hidden: float = 0.25


VISIBILITY_WEIGHT_PARAMETERS = VisibilityWeightParameters()


@wp.struct
@dataclass
class FarFieldParameters:
    """What is summed.

    near_spacings: VPL clusters nearer than so many spacings of a representative are not; grazing: light's gradient is
    taken as if cosines were no less, since below this it says nothing.
    """

    near_spacings: float = 3.0
    grazing: float = 0.1


FAR_FIELD_PARAMETERS: FarFieldParameters = parameters(FarFieldParameters)


@wp.func
def visibility_weight(share: float) -> float:
    """In what proportion to its light rays go to a VPL cluster, of which an SP's clusters see this share."""
    least = wp.static(VISIBILITY_WEIGHT_PARAMETERS.hidden)
    return least + (1.0 - least) * share


@wp.func
def light_seen(weighted: float, whole: float) -> float:
    """What of an SP's `whole` light its clusters see, by the sum of that in `visibility_weight`."""
    least = wp.static(VISIBILITY_WEIGHT_PARAMETERS.hidden)
    return (weighted - least * whole) / (1.0 - least)


@wp.struct
class FarLight:
    """Of each representative.

    near (representative, word): bit b of word w is 1 where VPL cluster 32·w + b is near; octets (representative, byte):
    the same bits.
    light (representative,): irradiance of the others by what it sees of them [W/m²]; position_gradient, normal_gradient
    (representative,): of its brightness, by place in unit space and by normal; unoccluded: tables, with a column each
    representative, of the light of far clusters were none hidden; weighted: of that light, each cluster's times its
    `visibility_weight`.
    """

    near: wp.array2d[wp.uint32]
    octets: wp.array2d[wp.uint8]
    light: wp.array[wp.vec3]
    position_gradient: wp.array[wp.vec3]
    normal_gradient: wp.array[wp.vec3]
    weighted: GroupTable
    unoccluded: GroupTable


@wp.struct
class Partial:
    """What each part adds to `light`, `position_gradient` and `normal_gradient` of FarLight, (part, representative)."""

    light: wp.array2d[wp.vec3]
    position_gradient: wp.array2d[wp.vec3]
    normal_gradient: wp.array2d[wp.vec3]


@wp.func
def is_near(position: wp.vec3, within: float, disk: Disk) -> bool:
    """Whether a VPL cluster's disk is so near a representative that its light may be other at its SPs."""
    return wp.length(disk.position - position) - disk.radius < within


@wp.struct
class IrradianceGradient:
    """Irradiance at a point [W/m²], and the gradients of its brightness by place and by normal."""

    light: wp.vec3
    position_gradient: wp.vec3
    normal_gradient: wp.vec3


@wp.func
def with_disk(slope: IrradianceGradient, position: wp.vec3, normal: wp.vec3, disk: Disk, grazing: float,
              ) -> IrradianceGradient:  # fmt: skip
    """`slope` with one more disk light."""
    whole = disk_irradiance(position, normal, disk)
    amount = brightness(whole)
    if amount <= 0.0:
        return slope
    way = disk.position - position
    squared = wp.length_sq(way)
    least = grazing * wp.sqrt(squared)
    facing = wp.max(wp.dot(way, normal), least)
    leaving = wp.max(-wp.dot(way, disk.normal), least)
    nearer = 1.0 / squared + PI / (PI * squared + disk.area)
    more = IrradianceGradient()
    more.light = slope.light + whole
    more.position_gradient = slope.position_gradient + amount * (
        way * (2.0 * nearer) - normal / facing + disk.normal / leaving
    )
    more.normal_gradient = slope.normal_gradient + way * (amount / facing)
    return more


@wp.func
def with_share(slope: IrradianceGradient, other: IrradianceGradient, share: float) -> IrradianceGradient:
    """`slope` with a share of another's light."""
    slope.light += other.light * share
    slope.position_gradient += other.position_gradient * share
    slope.normal_gradient += other.normal_gradient * share
    return slope


@wp.func
def with_subclusters(slope: IrradianceGradient, position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int,
                     lane: int, lanes: int, grazing: float) -> IrradianceGradient:  # fmt: skip
    """`slope` with the light of every `lanes`-th subcluster of a VPL cluster that is unfolded, as
    `unoccluded_irradiance` takes it.
    """
    end = vpls.starts[cluster + 1]
    begin = vpls.starts[cluster] + PER_SUBCLUSTER * lane
    for subcluster in range(vpls.subcluster_starts[cluster] + lane, vpls.subcluster_starts[cluster + 1], lanes):
        disk = disk_at(vpls.subclusters, subcluster)
        if is_subcluster_opened(position, disk):
            for member in range(begin, wp.min(begin + PER_SUBCLUSTER, end)):
                slope = with_disk(slope, position, normal, member_disk(vpls, member), grazing)
        else:
            slope = with_disk(slope, position, normal, disk, grazing)
        begin += PER_SUBCLUSTER * lanes
    return slope


@wp.kernel(module="unique", module_options={"fast_math": True})
def far_part_kernel(first: int, sps: SpClusters, lanes: int, vpls: VplClusters, visibility: wp.array2d[wp.uint32],
                    all_near: bool, chosen: FarFieldParameters, partial: Partial,
                    out: FarLight) -> None:  # fmt: skip
    """`lanes` threads a part of the groups at one new representative; neighbours have neighbouring ones."""
    index = first + wp.tid()
    fresh = sps.fresh[0]
    lane = index % lanes
    place = index // lanes
    if place >= out.weighted.cdf.shape[0] * fresh:
        return
    sp = sps.order[place % fresh]
    part = place // fresh
    position = sps.position[sp]
    normal = sps.normal[sp]
    within = chosen.near_spacings * sps.spacing[sp]
    whole = IrradianceGradient()
    part_mass = float(0.0)
    part_open = float(0.0)
    groups = groups_a_part(vpls, out.weighted.cdf.shape[0])
    begin = part * groups
    for group in range(begin, wp.min(begin + groups, vpls.groups)):
        importance = float(0.0)
        unoccluded_importance = float(0.0)
        reached = all_near or not out_of_reach(position, normal, vpls, group)
        end = wp.min(vpls.per_group * (group + 1), vpls.count)
        for octet in range(vpls.per_group * group // 8, (end + 7) // 8):
            near = int(0)
            unfolded = int(0)
            seen = visibility[sp, octet // 4] >> wp.uint32(8 * (octet % 4))
            if reached:
                for bit in range(lane, wp.min(8, end - 8 * octet), lanes):
                    vpl = 8 * octet + bit
                    disk = disk_at(vpls.disks, vpl)
                    if all_near:
                        near |= 1 << bit
                    elif not is_behind(position, normal, vpls, vpl):
                        if is_near(position, within, disk):
                            near |= 1 << bit
                        elif is_opened(position, disk):
                            unfolded |= 1 << bit
                        else:
                            share = float((seen >> wp.uint32(bit)) & wp.uint32(1))
                            lit = with_disk(IrradianceGradient(), position, normal, disk, chosen.grazing)
                            amount = brightness(lit.light)
                            unoccluded_importance += amount
                            importance += amount * visibility_weight(share)
                            whole = with_share(whole, lit, share)
            unfolded = bits_of_all(unfolded, lanes)
            while unfolded != 0:
                bit = lowest_bit(wp.uint32(unfolded))
                unfolded &= unfolded - 1
                share = float((seen >> wp.uint32(bit)) & wp.uint32(1))
                cluster = 8 * octet + bit
                lit = with_subclusters(
                    IrradianceGradient(), position, normal, vpls, cluster, lane, lanes, chosen.grazing
                )
                amount = brightness(lit.light)
                unoccluded_importance += amount
                importance += amount * visibility_weight(share)
                whole = with_share(whole, lit, share)
            near = bits_of_all(near, lanes)
            if lane == 0:
                out.octets[sp, octet] = wp.uint8(near)
        importance = float_sum(importance, lanes)
        unoccluded_importance = float_sum(unoccluded_importance, lanes)
        if lane == 0:
            out.weighted.importance[group, sp] = importance
            out.unoccluded.importance[group, sp] = unoccluded_importance
        part_mass += importance
        part_open += unoccluded_importance
    light = vector_sum(whole.light, lanes)
    position_gradient = vector_sum(whole.position_gradient, lanes)
    normal_gradient = vector_sum(whole.normal_gradient, lanes)
    if lane == 0:
        out.weighted.cdf[part, sp] = part_mass
        out.unoccluded.cdf[part, sp] = part_open
        partial.light[part, sp] = light
        partial.position_gradient[part, sp] = position_gradient
        partial.normal_gradient[part, sp] = normal_gradient


@wp.kernel
def far_sum_kernel(first: int, sps: SpClusters, vpls: VplClusters, partial: Partial, out: FarLight) -> None:
    """One thread a new representative: the sums over its parts."""
    place = first + wp.tid()
    if place >= sps.fresh[0]:
        return
    sp = sps.order[place]
    # Bits of lights with more clusters may still stand behind the last.
    for octet in range((vpls.count + 7) // 8, out.octets.shape[1]):
        out.octets[sp, octet] = wp.uint8(0)
    light = wp.vec3(0.0, 0.0, 0.0)
    position_gradient = wp.vec3(0.0, 0.0, 0.0)
    normal_gradient = wp.vec3(0.0, 0.0, 0.0)
    whole = float(0.0)
    whole_open = float(0.0)
    masses = Chunk()
    opens = Chunk()
    for chunk in range(out.weighted.cdf.shape[0] // wp.static(CHUNK)):
        for row in range(wp.static(CHUNK)):
            part = chunk * wp.static(CHUNK) + row
            light += partial.light[part, sp]
            position_gradient += partial.position_gradient[part, sp]
            normal_gradient += partial.normal_gradient[part, sp]
            masses[row] = out.weighted.cdf[part, sp]
            opens[row] = out.unoccluded.cdf[part, sp]
        for row in range(wp.static(CHUNK)):
            whole += masses[row]
            out.weighted.cdf[chunk * wp.static(CHUNK) + row, sp] = whole
            whole_open += opens[row]
            out.unoccluded.cdf[chunk * wp.static(CHUNK) + row, sp] = whole_open
    out.light[sp] = light
    out.position_gradient[sp] = position_gradient
    out.normal_gradient[sp] = normal_gradient


@wp.func
def far_irradiance(far: FarLight, clusters: SpClusters, cluster: int, position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """Irradiance of far VPL clusters at an SP by what one of its clusters knows [W/m²]."""
    light = far.light[cluster]
    amount = brightness(light)
    if amount <= 0.0:
        return light
    change = wp.dot(far.position_gradient[cluster], position - clusters.position[cluster])
    change += wp.dot(far.normal_gradient[cluster], normal - clusters.normal[cluster])
    return light * wp.clamp(1.0 + change / amount, 0.0, 2.0)


class FarSums:
    """Sums the far light of `sp_count` representatives; arrays are allocated once. `data` is what kernels take."""

    def __init__(self, sp_count: int, vpl_count: int, device: wp.Device, *, enabled: bool,
                 chosen: FarFieldParameters = FAR_FIELD_PARAMETERS) -> None:  # fmt: skip
        self.device, self._sp_count, self._vpl_count, self._enabled = device, sp_count, vpl_count, enabled
        self._chosen, self.data = chosen, self._allocate()
        self._partial: Partial = allocate(Partial, sp_count, device, PARTS)

    def for_another_viewer(self) -> "FarSums":
        """One with sums of its own; both share what a run only works with, so they run one after the other."""
        other = copy(self)
        other.data = self._allocate()
        return other

    def _allocate(self) -> FarLight:
        sp_count, words = self._sp_count, max(1, -(-self._vpl_count // 32))
        data: FarLight = allocate(FarLight, sp_count, self.device, 0)
        data.weighted = group_table(self._vpl_count, sp_count, self.device)
        data.unoccluded = group_table(self._vpl_count, sp_count, self.device)
        data.near = wp.zeros((sp_count, words), dtype=wp.uint32, device=self.device)
        data.octets = wp.array(ptr=data.near.ptr, dtype=wp.uint8, shape=(sp_count, 4 * words), device=self.device)
        return data

    def run(self, clusters: SpClusters, visibility: wp.array, vpls: VplClusters, *, few: bool) -> None:
        """Sum the light of `vpls` by the `visibility` bits of those of `clusters` that are new; others keep theirs.

        few: whether most are kept.
        """
        lanes = lanes_of(self.device, few=few)
        inputs = [clusters, lanes, vpls, visibility, not self._enabled, self._chosen, self._partial, self.data]
        launch(far_part_kernel, PARTS * self._sp_count * lanes, inputs, self.device)
        launch(far_sum_kernel, self._sp_count, [clusters, vpls, self._partial, self.data], self.device)

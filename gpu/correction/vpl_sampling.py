"""Where rays of shading points go: to which members of which VPL clusters."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from gpu.core.color import brightness
from gpu.core.parameters import parameters
from gpu.indirect.clustered_light import ClusteredLight, cluster_visibility_of, guides_of
from gpu.indirect.far_field import visibility_weight
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened, is_subcluster_opened, member_irradiance
from gpu.vpl.group_sampling import GroupTable, column_total, offered, reservoir, sample_group
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters


@wp.struct
@dataclass
class VplSampleParameters:
    """How much single rays count.

    most_share: a member of a cluster counts at most this many times as much as its cluster lets expect, and a group of
    clusters as much as the SP's clusters do.
    """

    most_share: float = 4.0


VPL_SAMPLE_PARAMETERS: VplSampleParameters = parameters(VplSampleParameters)


@wp.struct
class VplSample:
    """A VPL that a ray goes to, and its light over what its cluster lets expect of it.

    whole: brightness of the cluster were nothing between; scale, cluster_visibility: of that cluster's ClusterSample.
    """

    vpl: int
    share: float
    whole: float
    scale: float
    cluster_visibility: float


@wp.func
def far_member(vpls: VplClusters, cluster: int, area: float, state: wp.uint32) -> int:
    """A member of a cluster, whose disk has this `area`, drawn in proportion to its own area, which is as its flux.

    Where light paths begin as matters, flux differs a hundredfold: drawn evenly, rare members would leave fireflies.
    """
    rest = float(hashed(state)) * TO_UNIT * area
    vpl = int(vpls.starts[cluster])
    last = vpls.starts[cluster + 1] - 1
    while vpl < last and rest >= vpls.member_area[vpl]:
        rest -= vpls.member_area[vpl]
        vpl += 1
    return vpl


@wp.func
def member_of(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, state: wp.uint32,
              limits: VplSampleParameters) -> VplSample:  # fmt: skip
    """A member of a VPL cluster, drawn in proportion to its light where members are shaded one by one."""
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    target = VplSample()
    disk = disk_at(vpls.disks, cluster)
    if not is_opened(position, disk):
        target.vpl = far_member(vpls, cluster, disk.area, state)
        light = brightness(member_irradiance(position, normal, vpls, target.vpl, disk.area))
        light *= disk.area / wp.max(vpls.member_area[target.vpl], 1.0e-30)
        target.whole = brightness(disk_irradiance(position, normal, disk))
        target.share = wp.min(light / target.whole, limits.most_share)
        return target
    chosen = reservoir(state)
    start = int(begin)
    for subcluster in range(vpls.subcluster_starts[cluster], vpls.subcluster_starts[cluster + 1]):
        disk = disk_at(vpls.subclusters, subcluster)
        last = wp.min(start + PER_SUBCLUSTER, end)
        light = float(0.0)
        if is_subcluster_opened(position, disk):
            for member in range(start, last):
                light += brightness(member_irradiance(position, normal, vpls, member, vpls.member_area[member]))
        else:
            light = brightness(disk_irradiance(position, normal, disk))
        chosen = offered(chosen, start, light)
        start = last
    start = wp.max(chosen.item, begin)
    drawn = reservoir(chosen.state)
    for member in range(start, wp.min(start + PER_SUBCLUSTER, end)):
        light = brightness(member_irradiance(position, normal, vpls, member, vpls.member_area[member]))
        drawn = offered(drawn, member, light)
    target.vpl = wp.max(drawn.item, begin)
    target.share = 1.0
    target.whole = chosen.total
    return target


@wp.struct
class ClusterSample:
    """A VPL cluster that a ray goes to, −1 for none, and the share of the SP's clusters that see it.

    scale: what the group that it is of sends the SP, over what the SP's clusters let expect; state: of the random
    numbers.
    """

    cluster: int
    cluster_visibility: float
    scale: float
    state: wp.uint32


@cache
def far_sample_of(fuzziness: int, weighted: bool) -> wp.Function:
    """The function that draws a far VPL cluster for an SP of F = `fuzziness` clusters, `guided` by them.

    In proportion to its light, if `weighted` times its `visibility_weight` (gpu.indirect.far_field). pick: which of the
    SP's clusters has its table used, from 0 to the sum of what they know; where in that table the ray falls, 0 to 1.
    """
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)

    @wp.func
    def pick_cluster(guided: Any, table: GroupTable, u: float) -> int:
        picked = int(-1)
        for f in range(wp.static(fuzziness)):
            importance = guided.weight[f] * column_total(table, guided.cluster[f])
            if importance > 0.0:
                picked = guided.cluster[f]
                if u < importance:
                    break
                u -= importance
        return picked

    @wp.func
    def sample_far(position: wp.vec3, normal: wp.vec3, guided: Any, known: ClusteredLight, pick: wp.vec2,
                   state: wp.uint32, limits: VplSampleParameters) -> ClusterSample:  # fmt: skip
        table = known.far.unoccluded
        if wp.static(weighted):
            table = known.far.weighted
        sample = ClusterSample()
        sample.cluster = -1
        column = pick_cluster(guided, table, pick[0])
        if column < 0:
            return sample
        vpls = known.vpls
        cluster = guided.cluster
        weights = guided.weight
        group = sample_group(vpls, table, column, wp.clamp(pick[1], 0.0, 1.0) * column_total(table, column))
        expected = float(0.0)
        for f in range(wp.static(fuzziness)):
            if weights[f] > 0.0:
                expected += weights[f] * table.importance[group, cluster[f]]
        if expected <= 0.0:
            return sample
        near = wp.uint32(0)
        seen = words_type()
        drawn = reservoir(state)
        first_vpl = vpls.per_group * group
        for vpl in range(first_vpl, wp.min(first_vpl + vpls.per_group, vpls.count)):
            if vpl == first_vpl or vpl % 32 == 0:
                near = wp.uint32(0)
                for f in range(wp.static(fuzziness)):
                    seen[f] = known.visibility[cluster[f], vpl // 32]
                    if weights[f] > 0.0:
                        near |= known.far.near[cluster[f], vpl // 32]
            bit = wp.uint32(vpl % 32)
            amount = brightness(disk_irradiance(position, normal, disk_at(vpls.disks, vpl)))
            if amount > 0.0 and ((near >> bit) & wp.uint32(1)) == wp.uint32(0):
                share = float(0.0)
                for f in range(wp.static(fuzziness)):
                    share += weights[f] * float((seen[f] >> bit) & wp.uint32(1))
                if wp.static(weighted):
                    amount *= visibility_weight(share)
                drawn = offered(drawn, vpl, amount)
                if drawn.item == vpl:
                    sample.cluster_visibility = share
        sample.cluster = drawn.item
        sample.scale = wp.min(drawn.total / expected, limits.most_share)
        sample.state = drawn.state
        return sample

    return sample_far


@cache
def vpl_sample_of(fuzziness: int, weighted: bool) -> wp.Function:
    """The function that draws where a ray of an SP goes: to a member of the cluster `near`, or, if that is −1, to one
    of a far cluster, as `far_sample_of` tells. Its `vpl` is −1 where there is no light.
    """
    guides, sample_far = guides_of(fuzziness), far_sample_of(fuzziness, weighted)

    @wp.func
    def sample_vpl(position: wp.vec3, normal: wp.vec3, sp: int, known: ClusteredLight, near: int, pick: wp.vec2,
                   state: wp.uint32, limits: VplSampleParameters) -> VplSample:  # fmt: skip
        guided = guides(known, sp, position, normal)
        sample = VplSample()
        sample.vpl = -1
        drawn = ClusterSample()
        drawn.cluster = near
        drawn.scale = 1.0
        drawn.state = state
        if near >= 0:
            drawn.cluster_visibility = cluster_visibility_of(guided, known.visibility, near, wp.static(fuzziness))
        else:
            drawn = sample_far(position, normal, guided, known, pick, state, limits)
        if drawn.cluster >= 0:
            sample = member_of(position, normal, known.vpls, drawn.cluster, hashed(drawn.state), limits)
            sample.scale = drawn.scale
            sample.cluster_visibility = drawn.cluster_visibility
        return sample

    return sample_vpl

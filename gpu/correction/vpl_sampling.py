"""Where rays of shading points go: to which members of which VPL clusters, and whether they arrive."""

from functools import cache
from typing import Any

import warp as wp

from gpu.core.color import brightness
from gpu.device_scene.data import SceneData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened, is_subcluster_opened, member_irradiance
from gpu.vpl.group_sampling import sample_group
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters

# A member of a cluster counts at most this many times as much as its cluster lets expect, and a group of clusters as
# much as the SP's clusters do.
MOST_SHARE = wp.constant(4.0)


@wp.struct
class VplSample:
    """A VPL that a ray goes to, and its light over what its cluster lets expect of it.

    whole: brightness of the cluster were nothing between.
    """

    vpl: int
    share: float
    whole: float


@wp.func
def member_of(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int, state: wp.uint32) -> VplSample:
    """A member of a VPL cluster, drawn in proportion to its light where members are shaded one by one."""
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    number = float(end - begin)
    target = VplSample()
    disk = disk_at(vpls.disks, cluster)
    if not is_opened(position, disk):
        target.vpl = begin + int(hashed(state) % wp.uint32(end - begin))
        light = brightness(member_irradiance(position, normal, vpls, target.vpl, disk.area)) * number
        target.whole = brightness(disk_irradiance(position, normal, disk))
        target.share = wp.min(light / target.whole, MOST_SHARE)
        return target
    target.vpl = begin
    target.share = 1.0
    chosen = int(begin)
    area = disk.area / number
    total = float(0.0)
    for subcluster in range(vpls.subcluster_starts[cluster], vpls.subcluster_starts[cluster + 1]):
        disk = disk_at(vpls.subclusters, subcluster)
        last = wp.min(begin + PER_SUBCLUSTER, end)
        light = float(0.0)
        if is_subcluster_opened(position, disk):
            for member in range(begin, last):
                light += brightness(member_irradiance(position, normal, vpls, member, area))
        else:
            light = brightness(disk_irradiance(position, normal, disk))
        total += light
        state = hashed(state)
        if float(state) * TO_UNIT * total < light:
            chosen = begin
        begin = last
    target.whole = total
    total = float(0.0)
    for member in range(chosen, wp.min(chosen + PER_SUBCLUSTER, end)):
        light = brightness(member_irradiance(position, normal, vpls, member, area))
        total += light
        state = hashed(state)
        if float(state) * TO_UNIT * total < light:
            target.vpl = member
    return target


@wp.struct
class ClusterPick:
    """One of an SP's clusters, −1 for none, and what is left of a pick of its light in visibility_weight."""

    cluster: int
    u: float


@cache
def cluster_pick_of(fuzziness: int) -> wp.Function:
    """The function that finds which of an SP's F = `fuzziness` clusters a pick of their far light falls into.

    pick: from 0 to the sum of what they know, each by its share; totals (part, cluster): of
    gpu.indirect.far_field.FarLight.
    """

    @wp.func
    def pick_cluster(guided: Any, importance_cdf: wp.array2d[float], u: float) -> ClusterPick:
        guide = ClusterPick()
        guide.cluster = -1
        for f in range(wp.static(fuzziness)):
            importance = guided.weight[f] * importance_cdf[importance_cdf.shape[0] - 1, guided.cluster[f]]
            if importance > 0.0:
                guide.cluster = guided.cluster[f]
                guide.u = u
                if u < importance:
                    guide.u = u / guided.weight[f]
                    break
                u -= importance
                guide.u = u
        return guide

    return pick_cluster


@wp.struct
class FarSample:
    """A far VPL cluster that a ray goes to, −1 for none, and the share of the SP's clusters that see it.

    scale: what the group that it is of sends the SP, over what the SP's clusters let expect; state: of draws.
    """

    cluster: int
    cluster_visibility: float
    scale: float
    state: wp.uint32


@cache
def far_sample_of(fuzziness: int) -> wp.Function:
    """The function that draws a far VPL cluster for an SP of F = `fuzziness` clusters, `guided` by them.

    In proportion to light, where all clusters take it for hidden to the share `least` of that: mass, totals are the
    tables of gpu.indirect.far_field.FarLight that have it so; guide: where in them.
    """
    words_type = wp.types.vector(length=fuzziness, dtype=wp.uint32)

    @wp.func
    def sample_far(position: wp.vec3, normal: wp.vec3, guided: Any, visibility: wp.array2d[wp.uint32], vpls:
    VplClusters,
                 near_bits: wp.array2d[wp.uint32], importance: wp.array2d[float], importance_cdf: wp.array2d[float],
                 least: float, guide: ClusterPick, state: wp.uint32) -> FarSample:  # fmt: skip
        draw = FarSample()
        draw.cluster = -1
        draw.state = state
        if guide.cluster < 0:
            return draw
        cluster = guided.cluster
        weights = guided.weight
        group = sample_group(vpls, importance, importance_cdf, guide.cluster, guide.u)
        expected = float(0.0)
        for f in range(wp.static(fuzziness)):
            if weights[f] > 0.0:
                expected += weights[f] * importance[group, cluster[f]]
        if expected <= 0.0:
            return draw
        seen = words_type()
        total = float(0.0)
        near = wp.uint32(0)
        first_vpl = vpls.per_group * group
        for vpl in range(first_vpl, wp.min(first_vpl + vpls.per_group, vpls.count)):
            if vpl == first_vpl or vpl % 32 == 0:
                near = wp.uint32(0)
                for f in range(wp.static(fuzziness)):
                    seen[f] = visibility[cluster[f], vpl // 32]
                    if weights[f] > 0.0:
                        near |= near_bits[cluster[f], vpl // 32]
            bit = wp.uint32(vpl % 32)
            amount = brightness(disk_irradiance(position, normal, disk_at(vpls.disks, vpl)))
            if amount > 0.0 and ((near >> bit) & wp.uint32(1)) == wp.uint32(0):
                share = float(0.0)
                for f in range(wp.static(fuzziness)):
                    share += weights[f] * float((seen[f] >> bit) & wp.uint32(1))
                amount *= least + (1.0 - least) * share
                total += amount
                draw.state = hashed(draw.state)
                if float(draw.state) * TO_UNIT * total < amount:
                    draw.cluster = vpl
                    draw.cluster_visibility = share
        draw.scale = wp.min(total / expected, MOST_SHARE)
        return draw

    return sample_far


@wp.func
def cluster_visibility_of(guided: Any, visibility: wp.array2d[wp.uint32], cluster: int, fuzziness: int) -> float:
    """The share of an SP's clusters that see a VPL cluster."""
    share = float(0.0)
    for f in range(fuzziness):
        bits = visibility[guided.cluster[f], cluster // 32] >> wp.uint32(cluster % 32)
        share += guided.weight[f] * float(bits & wp.uint32(1))
    return share


@cache
def sees_member_of(connect: wp.Function) -> wp.Function:
    """The function that tells by `connect`, one of gpu.device_scene.rays.connected and connected_solid, whether an SP
    sees a VPL.
    """

    @wp.func
    def sees(scene: SceneData, gbuffer: GBuffer, pixel: int, vpls: VplClusters, vpl: int) -> bool:
        position = vpls.members.position[vpl]
        normal = vpls.members.normal[vpl]
        return bool(connect(scene, gbuffer.position[pixel], gbuffer.geometric_normal[pixel], position, normal))

    return sees

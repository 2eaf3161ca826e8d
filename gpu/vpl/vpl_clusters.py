"""VPL clusters as disk lights: what represents each cluster's VPLs in shading. Step 2 of the 2022 paper."""

import warp as wp

from gpu.core.search import upper_bound
from gpu.lights.light_paths import Vpls
from gpu.vpl.disk_light import Disk, disk_at, disk_of

# Unit space: rounding moves points of one plane apart by this much.
IN_PLANE = wp.constant(1.0e-6)
# VPLs in a subcluster.
PER_SUBCLUSTER = wp.constant(8)
# A group's clusters fill bytes of visibility bits; tables with an entry a group and SP cluster stay small.
LEAST_PER_GROUP = 8
MOST_GROUPS = 512


@wp.struct
class VplClusters:
    """Clusters of VPLs in the order of their seeds, so that neighbours on a surface lie side by side.

    One without members, which only those of reflective shadow maps may be, has a disk without flux, area and normal.

    disks (cluster,): what stands for them, at a member each; normal_cone_cos (cluster,): cosine of the widest angle
    between the representative's normal and a member's; extent, thickness (cluster,): the farthest member's distance,
    and that along the normal, unit space.
    Cluster c's members are starts[c] … starts[c + 1] − 1 of `members`. Of these, each PER_SUBCLUSTER that follow each
    other are a subcluster: disks subcluster_starts[c] … subcluster_starts[c + 1] − 1 of `subclusters`.
    path_flux (vpl,): that members bring by the light that paths are drawn by (gpu.scene.lighting.path_light), of which
    all but the flux of disks and members is made; member_area (vpl,): each one's share of its cluster's disk, as large
    as that of its path flux.
    Each `per_group` clusters that are neighbours form a group, of which there are `groups`. centre, radius (group,): a
    sphere that holds all of its members; axis, axis_cone_cos (group,): axis and cosine of the angle of a cone that
    holds their normals.
    """

    count: int
    per_group: int
    groups: int
    disks: wp.array[Disk]
    normal_cone_cos: wp.array[float]
    extent: wp.array[float]
    thickness: wp.array[float]
    starts: wp.array[int]
    members: Vpls
    path_flux: wp.array[wp.vec3]
    member_area: wp.array[float]
    subcluster_starts: wp.array[int]
    subclusters: wp.array[Disk]
    centre: wp.array[wp.vec3]
    radius: wp.array[float]
    axis: wp.array[wp.vec3]
    axis_cone_cos: wp.array[float]


@wp.func
def cluster_of(clusters: VplClusters, member: int) -> int:
    """The cluster that a member belongs to."""
    return upper_bound(clusters.starts, clusters.count, member) - 1


@wp.func
def out_of_reach(position: wp.vec3, normal: wp.vec3, clusters: VplClusters, group: int) -> bool:
    """Whether no member of a group can light a point: all lie behind its surface, or it behind all of theirs."""
    way = position - clusters.centre[group]
    radius = clusters.radius[group]
    if wp.dot(way, normal) >= radius:
        return True
    distance = wp.length(way)
    across = wp.dot(way, clusters.axis[group])
    axis_cone_cos = clusters.axis_cone_cos[group]
    if across >= distance * axis_cone_cos or distance <= radius:
        return False
    # cos(θ − α), of the normal that is nearest to the direction of the point.
    beside = wp.sqrt(wp.max(distance * distance - across * across, 0.0))
    return across * axis_cone_cos + beside * wp.sqrt(wp.max(1.0 - axis_cone_cos * axis_cone_cos, 0.0)) + radius <= 0.0


@wp.func
def member_disk(clusters: VplClusters, member: int) -> Disk:
    """A VPL as a disk light of its own."""
    members = clusters.members
    area = clusters.member_area[member]
    return disk_of(members.position[member], members.normal[member], members.flux[member], area, 0.0, 1.0)


@wp.func
def is_behind(position: wp.vec3, normal: wp.vec3, clusters: VplClusters, cluster: int) -> bool:
    """Whether all members of a cluster lie in or behind the plane of a point's surface, as those of that surface do."""
    disk = disk_at(clusters.disks, cluster)
    alike = wp.dot(normal, disk.normal)
    height = wp.dot(disk.position - position, normal)
    height += clusters.extent[cluster] * wp.sqrt(wp.max(1.0 - alike * alike, 0.0))
    return height + clusters.thickness[cluster] * wp.abs(alike) <= IN_PLANE


def most_groups(count: int) -> int:
    """The most groups that up to `count` clusters form."""
    return min(MOST_GROUPS, -(-count // LEAST_PER_GROUP))

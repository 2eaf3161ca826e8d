"""Light from disk lights and VPL clusters to a point, were nothing in between. Eq. 4 of the 2022 paper."""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import PI
from gpu.core.kahan import Sum, kahan_add
from gpu.vpl.disk_light import Disk, disk_at
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters, cluster_of, is_behind


@dataclass(frozen=True)
class OpeningParameters:
    """A cluster's disk, or a subcluster's, whose squared radius is more than this times the squared distance gives way
    to what it stands for. Compiled in: the innermost loop of shading compares with them.
    """

    cluster: float = 0.167
    subcluster: float = 0.05


OPENING_PARAMETERS = OpeningParameters()


@wp.func
def light_of(vpls: VplClusters, vpl: int, amount: float) -> wp.vec3:
    """Light of the brightness `amount` in the colour of a VPL."""
    flux = vpls.members.flux[vpl]
    return flux * (amount / brightness(flux))


@wp.func
def disk_transfer(way: wp.vec3, normal: wp.vec3, disk_normal: wp.vec3, area: float) -> float:
    """Share of a disk light's flux that arrives per area at an unoccluded point `-way` from it: form factor over area.

    cosθ·cosθ′ / (π·d² + A), which is bounded by 1/A, where point lights' 1/d² makes bright spots.
    """
    squared = wp.length_sq(way)
    facing = wp.dot(way, normal)
    leaving = -wp.dot(way, disk_normal)
    if facing <= 0.0 or leaving <= 0.0:
        return 0.0
    return facing * leaving / (squared * (PI * squared + area))


@wp.func
def positive_mean(value: float, spread: float) -> float:
    """Mean of the positive part of what is spread evenly by ± `spread` around `value`."""
    if value >= spread:
        return value
    if value <= -spread:
        return 0.0
    return (value + spread) * (value + spread) / (4.0 * spread)


@wp.func
def disk_irradiance(position: wp.vec3, normal: wp.vec3, disk: Disk) -> wp.vec3:
    """Irradiance at a point from a disk light that stands for VPLs, if nothing hides it [W/m²].

    A part of a disk may be above a surface's horizon when its representative is not, and light what that faces away
    from: cosines are means over the disk and over the cone of its members' normals.
    """
    nothing = wp.vec3(0.0, 0.0, 0.0)
    way = disk.position - position
    facing = wp.dot(way, normal)
    if facing <= -disk.radius:
        return nothing
    leaving = -wp.dot(way, disk.normal)
    squared = wp.length_sq(way)
    if leaving <= 0.0 and leaving * leaving >= disk.tilt * disk.tilt * squared:
        return nothing
    # Square roots are for those that are near a horizon.
    if facing < disk.radius:
        normal_cosine = wp.dot(normal, disk.normal)
        facing = positive_mean(facing, disk.radius * wp.sqrt(wp.max(1.0 - normal_cosine * normal_cosine, 0.0)))
    if leaving * leaving < disk.tilt * disk.tilt * squared:
        leaving = positive_mean(leaving, disk.tilt * wp.sqrt(squared))
    return disk.flux * (facing * leaving / (squared * (PI * squared + disk.area)))


@wp.func
def is_opened(position: wp.vec3, disk: Disk) -> bool:
    """Whether a cluster's disk is so near that its subclusters are shaded in its place: it would be too coarse."""
    return disk.radius * disk.radius > wp.static(OPENING_PARAMETERS.cluster) * wp.length_sq(disk.position - position)


@wp.func
def is_subcluster_opened(position: wp.vec3, subcluster: Disk) -> bool:
    """Whether a subcluster's disk is so near that its members are shaded in its place."""
    share = wp.static(OPENING_PARAMETERS.subcluster)
    return subcluster.radius * subcluster.radius > share * wp.length_sq(subcluster.position - position)


@wp.func
def disk_area(position: wp.vec3, vpls: VplClusters, member: int) -> float:
    """Area of the disk as part of which a VPL lights a point: its cluster's, its subcluster's or its own."""
    cluster = cluster_of(vpls, member)
    disk = disk_at(vpls.disks, cluster)
    if not is_opened(position, disk):
        return disk.area
    begin = vpls.starts[cluster]
    subcluster = disk_at(vpls.subclusters, vpls.subcluster_starts[cluster] + (member - begin) // PER_SUBCLUSTER)
    if not is_subcluster_opened(position, subcluster):
        return subcluster.area
    return vpls.member_area[member]


@wp.func
def member_irradiance(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, member: int, area: float) -> wp.vec3:
    """Irradiance at a point from one VPL with a disk of `area`, if nothing hides it [W/m²]."""
    way = vpls.members.position[member] - position
    return vpls.members.flux[member] * disk_transfer(way, normal, vpls.members.normal[member], area)


@wp.func
def unoccluded_irradiance(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int) -> wp.vec3:
    """Irradiance at a point from a VPL cluster that nothing hides [W/m²].

    Near a cluster its one disk would be too coarse and too dim: there its subclusters count one by one, and of
    subclusters that are as near, the members.
    """
    disk = disk_at(vpls.disks, cluster)
    if not is_opened(position, disk):
        return disk_irradiance(position, normal, disk)
    irradiance = Sum()
    if is_behind(position, normal, vpls, cluster):
        return irradiance.total
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    for subcluster in range(vpls.subcluster_starts[cluster], vpls.subcluster_starts[cluster + 1]):
        disk = disk_at(vpls.subclusters, subcluster)
        if is_subcluster_opened(position, disk):
            for member in range(begin, wp.min(begin + PER_SUBCLUSTER, end)):
                area = vpls.member_area[member]
                irradiance = kahan_add(irradiance, member_irradiance(position, normal, vpls, member, area))
        else:
            irradiance = kahan_add(irradiance, disk_irradiance(position, normal, disk))
        begin += PER_SUBCLUSTER
    return irradiance.total

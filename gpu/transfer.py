"""Light from disk lights and VPL clusters to a point, were nothing in between. Eq. 4 of the 2022 paper."""

import warp as wp

from gpu.sampling import PI
from gpu.sums import Sum, added
from gpu.vpl_clusters import VplClusters, is_behind

# A cluster whose disk has more area than this times the squared distance is shaded member by member.
UNFOLD_SHARE = wp.constant(0.7)


@wp.func
def brightness(radiance: wp.vec3) -> float:
    """One number for how bright a radiance is."""
    return (radiance[0] + radiance[1] + radiance[2]) / 3.0


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
def disk_irradiance(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int) -> wp.vec3:
    """Irradiance at a point from a VPL cluster's one disk, if nothing hides it [W/m²].

    A part of a disk may be above a surface's horizon when its representative is not, and light what that faces away
    from: cosines are means over the disk and over the cone of its members' normals.
    """
    nothing = wp.vec3(0.0, 0.0, 0.0)
    way = vpls.position[cluster] - position
    reach = vpls.reach[cluster]
    facing = wp.dot(way, normal)
    if facing <= -reach:
        return nothing
    disk_normal = vpls.normal[cluster]
    leaving = -wp.dot(way, disk_normal)
    squared = wp.length_sq(way)
    turn = vpls.turn[cluster]
    if leaving <= 0.0 and leaving * leaving >= turn * turn * squared:
        return nothing
    # Square roots are for those that are near a horizon.
    if facing < reach:
        tilt = wp.dot(normal, disk_normal)
        facing = positive_mean(facing, reach * wp.sqrt(wp.max(1.0 - tilt * tilt, 0.0)))
    if leaving * leaving < turn * turn * squared:
        leaving = positive_mean(leaving, turn * wp.sqrt(squared))
    return vpls.flux[cluster] * (facing * leaving / (squared * (PI * squared + vpls.area[cluster])))


@wp.func
def is_unfolded(position: wp.vec3, vpls: VplClusters, cluster: int) -> bool:
    """Whether a VPL cluster is so near that its members are shaded one by one: its one disk would be too coarse."""
    return vpls.area[cluster] > UNFOLD_SHARE * wp.length_sq(vpls.position[cluster] - position)


@wp.func
def disk_area(vpls: VplClusters, cluster: int, squared: float) -> float:
    """Area of the disks that stand for a VPL cluster at a squared distance: of its one, or near by of each member's."""
    area = vpls.area[cluster]
    if area <= UNFOLD_SHARE * squared:
        return area
    return area / float(vpls.starts[cluster + 1] - vpls.starts[cluster])


@wp.func
def unoccluded(position: wp.vec3, normal: wp.vec3, vpls: VplClusters, cluster: int) -> wp.vec3:
    """Irradiance at a point from a VPL cluster that nothing hides [W/m²].

    Near a cluster its one disk would be too coarse and too dim, so its members count one by one there.
    """
    if not is_unfolded(position, vpls, cluster):
        return disk_irradiance(position, normal, vpls, cluster)
    irradiance = Sum()
    if is_behind(position, normal, vpls, cluster):
        return irradiance.total
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    area = vpls.area[cluster] / float(end - begin)
    for member in range(begin, end):
        way = vpls.members.position[member] - position
        share = disk_transfer(way, normal, vpls.members.normal[member], area)
        irradiance = added(irradiance, vpls.members.flux[member] * share)
    return irradiance.total

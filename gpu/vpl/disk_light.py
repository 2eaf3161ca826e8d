"""Disk lights: what stands for VPL clusters and parts of them in shading (2022 paper, section 3.1, step 2)."""

import warp as wp

# A uniform disk of radius R has the variance R²/2 about its centre, and the deviation R/2 along any line in it, as an
# even spread of ± R·√3/2 has.
EVEN_SQUARE = wp.constant(1.5)
# The deviation of members' normals over the widest of them.
CONE_SHARE = wp.constant(0.5)


@wp.struct
class Disk:
    """A disk light that stands for VPLs, its fields side by side, since whoever reads one reads all.

    position, normal: of the representative; flux: summed over members [W], per channel; area: of the disk that spreads
    as the members do, unit space squared; radius: ± what members are spread by along any line in the disk, unit space;
    tilt: ± what the cosines of their normals are spread by.
    """

    position: wp.vec3
    area: float
    normal: wp.vec3
    radius: float
    flux: wp.vec3
    tilt: float


@wp.func
def disk_of(
    position: wp.vec3, normal: wp.vec3, flux: wp.vec3, area: float, variance: float, normal_cone_cos: float
) -> Disk:
    """A disk light; area, variance: of the places of what it stands for, unit space squared; normal_cone_cos: cosine of
    the widest angle of its normals.
    """
    disk = Disk()
    disk.position = position
    disk.normal = normal
    disk.flux = flux
    disk.area = area
    disk.radius = wp.sqrt(EVEN_SQUARE * variance)
    disk.tilt = CONE_SHARE * wp.sqrt(wp.max(1.0 - normal_cone_cos * normal_cone_cos, 0.0))
    return disk


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const float4 four = __ldg(reinterpret_cast<const float4*>(disks.data + index) + part);
    return wp::vec_t<4, wp::float32>(four.x, four.y, four.z, four.w);
#else
    return reinterpret_cast<const wp::vec_t<4, wp::float32>*>(disks.data + index)[part];
#endif
""")
def third_of(disks: wp.array[Disk], index: int, part: int) -> wp.vec4:
    """Four neighbouring floats of a disk, of which it has three times as many, by one load."""


@wp.func
def disk_at(disks: wp.array[Disk], index: int) -> Disk:
    """One of `disks`, read by three loads instead of twelve: shading waits for little else."""
    place = third_of(disks, index, 0)
    side = third_of(disks, index, 1)
    light = third_of(disks, index, 2)
    disk = Disk()
    disk.position = wp.vec3(place[0], place[1], place[2])
    disk.area = place[3]
    disk.normal = wp.vec3(side[0], side[1], side[2])
    disk.radius = side[3]
    disk.flux = wp.vec3(light[0], light[1], light[2])
    disk.tilt = light[3]
    return disk

"""Polygons that stand for clusters of shadow maps: section 5 and Fig. 3 of the 2012 paper.

A cluster's polygon has eight sides, each as far out as its members lie in that direction of the plane, so that long
clusters have long lights where disks are round.
"""

from typing import Any

import warp as wp

from gpu.core.constants import FAR_AWAY, TWO_PI
from gpu.core.device import launch
from gpu.sampling.warps import orthonormal
from gpu.vpl.disk_light import disk_at
from gpu.vpl.vpl_clusters import VplClusters

SIDES = 8
# Unit space: half of the width of what has no width, so that its radiosity has a bound.
LEAST_MARGIN = wp.constant(1.0e-4)
Supports: Any = wp.types.vector(length=SIDES, dtype=float)


@wp.struct
class Polygons:
    """corners (corner, cluster): counterclockwise as seen from where a cluster's normal points; radiosity (cluster,)
    [W/m²]: its flux over the polygon's area.
    """

    corners: wp.array2d[wp.vec3]
    radiosity: wp.array[wp.vec3]


@wp.kernel
def polygon_kernel(first: int, vpls: VplClusters, out: Polygons) -> None:
    """One thread a cluster: the polygon around its members, half a member wider than they lie."""
    cluster = first + wp.tid()
    begin = vpls.starts[cluster]
    end = vpls.starts[cluster + 1]
    out.radiosity[cluster] = wp.vec3(0.0, 0.0, 0.0)
    if begin == end:
        return
    disk = disk_at(vpls.disks, cluster)
    frame = orthonormal(disk.normal)
    tangent = wp.vec3(frame[0, 0], frame[1, 0], frame[2, 0])
    bitangent = wp.vec3(frame[0, 1], frame[1, 1], frame[2, 1])
    step = TWO_PI / float(wp.static(SIDES))
    support = Supports()
    for side in range(wp.static(SIDES)):
        support[side] = -FAR_AWAY
    for member in range(begin, end):
        off = vpls.members.position[member] - disk.position
        x = wp.dot(off, tangent)
        y = wp.dot(off, bitangent)
        for side in range(wp.static(SIDES)):
            turn = step * float(side)
            support[side] = wp.max(support[side], x * wp.cos(turn) + y * wp.sin(turn))
    margin = wp.max(0.5 * wp.sqrt(disk.area / float(end - begin)), LEAST_MARGIN)
    area = float(0.0)
    for side in range(wp.static(SIDES)):
        turn = step * float(side)
        height = support[side] + margin
        following = (support[(side + 1) % wp.static(SIDES)] + margin - height * wp.cos(step)) / wp.sin(step)
        before = (support[(side + wp.static(SIDES) - 1) % wp.static(SIDES)] + margin - height * wp.cos(step)) / wp.sin(
            step
        )
        # The triangle of the centre and this side.
        area += 0.5 * height * (following + before)
        x = height * wp.cos(turn) - following * wp.sin(turn)
        y = height * wp.sin(turn) + following * wp.cos(turn)
        out.corners[side, cluster] = disk.position + tangent * x + bitangent * y
    out.radiosity[cluster] = disk.flux / area


@wp.func
def edge_term(a: wp.vec3, b: wp.vec3, normal: wp.vec3) -> float:
    """What the edge between two corners, as seen from a point, adds to a form factor: Γ·n, times 2π."""
    across = wp.cross(a, b)
    length = wp.length(across)
    if length <= 0.0:
        return 0.0
    return wp.atan2(length, wp.dot(a, b)) * wp.dot(across, normal) / length


@wp.func
def polygon_irradiance(position: wp.vec3, normal: wp.vec3, polygons: Polygons, vpls: VplClusters, cluster: int,
                       ) -> wp.vec3:  # fmt: skip
    """Irradiance at a point from a cluster's polygon, if nothing hides it [W/m²].

    The form factor of a point and a polygon, of which what lies below the point's horizon is cut off (D. Baum et al.,
    Improving Radiosity Solutions Through the Use of Analytically Determined Form-Factors, 1989).
    """
    nothing = wp.vec3(0.0, 0.0, 0.0)
    radiosity = polygons.radiosity[cluster]
    disk = disk_at(vpls.disks, cluster)
    if radiosity[0] + radiosity[1] + radiosity[2] <= 0.0 or wp.dot(position - disk.position, disk.normal) <= 0.0:
        return nothing
    total = float(0.0)
    sinks = wp.vec3(0.0, 0.0, 0.0)
    rises = wp.vec3(0.0, 0.0, 0.0)
    cuts = int(0)
    a = polygons.corners[wp.static(SIDES) - 1, cluster] - position
    above = wp.dot(a, normal)
    for corner in range(wp.static(SIDES)):
        b = polygons.corners[corner, cluster] - position
        next_above = wp.dot(b, normal)
        one = a
        other = b
        if (above > 0.0) != (next_above > 0.0):
            edge = a + (b - a) * (above / (above - next_above))
            cuts += 1
            if above > 0.0:
                sinks = edge
                other = edge
            else:
                rises = edge
                one = edge
        if above > 0.0 or next_above > 0.0:
            total += edge_term(one, other, normal)
        a = b
        above = next_above
    if cuts > 0:
        total += edge_term(sinks, rises, normal)
    # Counterclockwise from the light's front is clockwise from the point.
    return radiosity * wp.max(-total / TWO_PI, 0.0)


def allocate_polygons(vpls: VplClusters, device: wp.Device) -> Polygons:
    """One for each of `vpls`, without light yet."""
    polygons = Polygons()
    polygons.corners = wp.zeros((SIDES, vpls.count), dtype=wp.vec3, device=device)
    polygons.radiosity = wp.zeros(vpls.count, dtype=wp.vec3, device=device)
    return polygons


def fit_polygons(vpls: VplClusters, out: Polygons) -> None:
    """Make in `out` the polygons of `vpls`, in arrays that stay."""
    launch(polygon_kernel, vpls.count, [vpls, out], out.radiosity.device)

"""The representatives nearest to a surface point: the innermost loop of Algorithms 1 and 2 of the 2022 paper."""

from functools import cache
from typing import Any

import warp as wp

from gpu.clustering.grid import (
    ClusteringParameters,
    Representatives,
    bucket_of,
    cell_at,
    cells_per_unit,
    entry_at,
    separation,
)
from gpu.core.constants import FAR_AWAY

# Farther than anything in unit space, even stretched: a like normal comes first, but no point is left out.
OTHER_NORMAL = wp.constant(100.0)


@wp.struct
class NeighbourCell:
    """A cell, and how far a point is from it, in cells."""

    cell: wp.vec3i
    gap: float


@wp.func
def neighbour_cell(centre: wp.vec3i, place: wp.vec3, number: int) -> NeighbourCell:
    """Cell `number`, 0 … 26, of those about a point at `place`, from 0 to 1, in the cell `centre`; nearer ones first.

    On each axis comes the centre, then what lies beside the nearer face, then what is opposite.
    """
    found = NeighbourCell()
    found.cell = centre
    square = float(0.0)
    for axis in range(3):
        step = number % 3
        number = number // 3
        side = wp.where(place[axis] > 0.5, 1, -1)
        near = wp.min(place[axis], 1.0 - place[axis])
        if step == 1:
            found.cell[axis] = centre[axis] + side
            square += near * near
        elif step == 2:
            found.cell[axis] = centre[axis] - side
            square += (1.0 - near) * (1.0 - near)
    found.gap = wp.sqrt(square)
    return found


@wp.func
def one_try(chosen: ClusteringParameters) -> int:
    """How often a search that does not widen is made: known when it is compiled, so that it has no loop."""
    return 1


@wp.func
def twice_wider_levels(chosen: ClusteringParameters) -> int:
    """How often one that widens is made: with normals that are alike, then with others."""
    return 2 * chosen.wider_levels


@cache
def nearest_search(number: int, metric: wp.Function = separation, *, widens: bool = False) -> wp.Function:
    """The function that finds the `number` representatives nearest to a point by `metric`, in the 27 cells about it.

    search(clusters, position, normal, level) has `distance` and `cluster`, vectors of `number` elements,
    nearest first, −1 where there are no more; normals must be alike (Eq. 7).
    widens: where there is none, wider cells are searched, then all of them for those with other normals; `alike` tells
    whether that was not necessary.
    """
    most_tries = twice_wider_levels if widens else one_try
    distances: Any = wp.types.vector(length=number, dtype=float)
    indices: Any = wp.types.vector(length=number, dtype=int)

    @wp.struct
    class Nearest:
        distance: distances
        cluster: indices
        alike: bool

    @wp.func
    def search(clusters: Representatives, position: wp.vec3, normal: wp.vec3, level: int) -> Nearest:
        chosen = clusters.chosen
        threshold = chosen.normal_threshold
        nearest = Nearest()
        for f in range(wp.static(number)):
            nearest.distance[f] = FAR_AWAY
            nearest.cluster[f] = -1
        nearest.alike = True
        tried = int(0)
        while nearest.cluster[0] < 0 and tried < most_tries(chosen):
            if wp.static(widens) and tried == chosen.wider_levels:
                level -= chosen.wider_levels
                threshold = chosen.relaxed_threshold
                nearest.alike = False
            scale = cells_per_unit(level)
            centre = cell_at(position, scale)
            place_in_cell = position * scale - wp.vec3(float(centre[0]), float(centre[1]), float(centre[2]))
            for neighbour in range(27):
                cell = neighbour_cell(centre, place_in_cell, neighbour)
                # No metric makes anything nearer than it is, so cells farther than all that was found hold nothing new.
                if cell.gap > nearest.distance[wp.static(number - 1)] * scale:
                    continue
                bucket = bucket_of(cell.cell, level, clusters.buckets)
                for place in range(clusters.starts[bucket], clusters.starts[bucket + 1]):
                    entry = entry_at(clusters, place)
                    here = entry.level == level and cell_at(entry.position, scale) == cell.cell
                    if here and wp.dot(entry.normal, normal) > threshold:
                        cluster = entry.cluster
                        distance = metric(chosen, position, normal, entry.position, entry.normal)
                        if distance >= nearest.distance[wp.static(number - 1)]:
                            continue
                        for f in range(wp.static(number)):
                            if distance < nearest.distance[f]:
                                held_distance = nearest.distance[f]
                                held_cluster = nearest.cluster[f]
                                nearest.distance[f] = distance
                                nearest.cluster[f] = cluster
                                distance = held_distance
                                cluster = held_cluster
            tried += 1
            level += 1
        return nearest

    return search


@wp.func
def nearest_of_all(clusters: Representatives, count: int, position: wp.vec3, normal: wp.vec3, threshold: float,
                   every: int) -> int:  # fmt: skip
    """The nearest of the first `count` representatives in use, of those with a like normal if there are any.

    −1 if none is in use. every: 1, or of so many that follow each other just one is looked at.
    """
    best = int(-1)
    best_distance = float(FAR_AWAY)
    for cluster in range(0, count, every):
        if clusters.spacing[cluster] > 0.0:
            candidate_normal = clusters.normal[cluster]
            distance = separation(clusters.chosen, position, normal, clusters.position[cluster], candidate_normal)
            if wp.dot(candidate_normal, normal) <= threshold:
                distance += OTHER_NORMAL
            if distance < best_distance:
                best_distance = distance
                best = cluster
    return best


@wp.func
def nearest_of_some(clusters: Representatives, count: int, position: wp.vec3, normal: wp.vec3, search: int) -> int:
    """About the nearest of the first `count` representatives in use: of about `search` of them, or of all if none of
    these is in use. One with a normal that is not opposite comes first. −1 if none is in use.
    """
    threshold = clusters.chosen.relaxed_threshold
    nearest = nearest_of_all(clusters, count, position, normal, threshold, 1 + count // search)
    if nearest < 0:
        nearest = nearest_of_all(clusters, count, position, normal, threshold, 1)
    return nearest

"""The representatives nearest to a surface point: the innermost loop of Algorithms 1 and 2 of the 2022 paper."""

from functools import cache
from typing import Any

import warp as wp

from gpu.grid import FAR_AWAY, Representatives, bucket_of, cell_at, cells_per_unit, separation

# Farther than anything in unit space, even stretched: a like normal comes first, but no point is left out.
OTHER_NORMAL = wp.constant(100.0)


@cache
def nearest_search(number: int, metric: wp.Function = separation) -> wp.Function:
    """The function that finds the `number` representatives nearest to a point by `metric`, in the 27 cells about it.

    search(clusters, position, normal, level, threshold) has `distance` and `cluster`, vectors of `number` elements,
    nearest first, −1 where there are no more; the cosine between normals must exceed `threshold` (Eq. 7).
    """
    distances: Any = wp.types.vector(length=number, dtype=float)
    indices: Any = wp.types.vector(length=number, dtype=int)

    @wp.struct
    class Nearest:
        distance: distances
        cluster: indices

    @wp.func
    def search(clusters: Representatives, position: wp.vec3, normal: wp.vec3, level: int, threshold: float) -> Nearest:
        nearest = Nearest()
        for f in range(wp.static(number)):
            nearest.distance[f] = FAR_AWAY
            nearest.cluster[f] = -1
        scale = cells_per_unit(level)
        centre = cell_at(position, scale)
        # Cells come by how far they are: on each axis the own one, the one beside the nearer face, and that opposite.
        side = wp.vec3i(-1, -1, -1)
        near = wp.vec3(0.0, 0.0, 0.0)
        for axis in range(3):
            near[axis] = position[axis] * scale - float(centre[axis])
            if near[axis] > 0.5:
                side[axis] = 1
                near[axis] = 1.0 - near[axis]
        for neighbour in range(27):
            step = wp.vec3i(neighbour % 3, (neighbour // 3) % 3, neighbour // 9)
            gap = float(0.0)
            cell = centre
            for axis in range(3):
                if step[axis] == 1:
                    cell[axis] = centre[axis] + side[axis]
                    gap += near[axis] * near[axis]
                elif step[axis] == 2:
                    cell[axis] = centre[axis] - side[axis]
                    gap += (1.0 - near[axis]) * (1.0 - near[axis])
            # All that is in the cell is farther than those found; no metric makes anything nearer than it is.
            if wp.sqrt(gap) > nearest.distance[wp.static(number - 1)] * scale:
                continue
            bucket = bucket_of(cell, level, clusters.buckets)
            for place in range(clusters.starts[bucket], clusters.starts[bucket + 1]):
                entry = clusters.entries[place]
                cluster = entry // 3
                candidate = clusters.position[cluster]
                if clusters.level[cluster] + entry % 3 - 1 == level and cell_at(candidate, scale) == cell:
                    candidate_normal = clusters.normal[cluster]
                    if wp.dot(candidate_normal, normal) > threshold:
                        distance = metric(position, normal, candidate, candidate_normal)
                        for f in range(wp.static(number)):
                            if distance < nearest.distance[f]:
                                held_distance = nearest.distance[f]
                                held_cluster = nearest.cluster[f]
                                nearest.distance[f] = distance
                                nearest.cluster[f] = cluster
                                distance = held_distance
                                cluster = held_cluster
        return nearest

    return search


@wp.func
def nearest_of_all(clusters: Representatives, position: wp.vec3, normal: wp.vec3, threshold: float, every: int) -> int:
    """The nearest of all representatives in use, of those with a like normal if there are any; −1 if none is in use.

    every: 1, or of so many that follow each other just one is looked at.
    """
    best = int(-1)
    best_distance = float(FAR_AWAY)
    for cluster in range(0, clusters.spacing.shape[0], every):
        if clusters.spacing[cluster] > 0.0:
            candidate_normal = clusters.normal[cluster]
            distance = separation(position, normal, clusters.position[cluster], candidate_normal)
            if wp.dot(candidate_normal, normal) <= threshold:
                distance += OTHER_NORMAL
            if distance < best_distance:
                best_distance = distance
                best = cluster
    return best

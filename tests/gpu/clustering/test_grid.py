import numpy as np
import warp as wp
from scenes import column, results

from gpu.clustering.grid import (
    CLUSTERING_PARAMETERS,
    ClusteringParameters,
    Grid,
    Representatives,
    bucket_of,
    cell_at,
    cells_per_unit,
    entry_at,
    level_of,
    separation,
)

CPU = wp.get_device("cpu")
# How much more a distance along the normal counts than one along the surface.
STRETCH = 8.0


@wp.kernel
def near_kernel(first: int, clusters: Representatives, position: wp.array[wp.vec3], spacing: float, limit: float,
                found: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: how many representatives within `limit` the 27 cells about it hold."""
    point = first + wp.tid()
    level = level_of(clusters.chosen, spacing)
    scale = cells_per_unit(level)
    centre = cell_at(position[point], scale)
    number = int(0)
    for neighbour in range(27):
        cell = centre + wp.vec3i(neighbour % 3 - 1, (neighbour // 3) % 3 - 1, neighbour // 9 - 1)
        bucket = bucket_of(cell, level, clusters.buckets)
        for place in range(clusters.starts[bucket], clusters.starts[bucket + 1]):
            entry = entry_at(clusters, place)
            here = entry.level == level and cell_at(entry.position, scale) == cell
            if here and wp.length(entry.position - position[point]) < limit:
                number += 1
    found[point] = number


@wp.kernel
def separation_kernel(
    first: int, chosen: ClusteringParameters, offset: wp.array[wp.vec3], out: wp.array[float]
) -> None:
    """One thread an offset between two points that face up."""
    index = first + wp.tid()
    up = wp.vec3(0.0, 1.0, 0.0)
    out[index] = separation(chosen, wp.vec3(0.0, 0.0, 0.0), up, offset[index], up)


def test_every_representative_within_a_spacing_is_found_once() -> None:
    rng = np.random.default_rng(2)
    centres, points = rng.uniform(-0.5, 0.5, (400, 3)), rng.uniform(-0.5, 0.5, (300, 3))
    spacing = 0.11
    grid = Grid(400, CPU)
    grid.data.position.assign(centres.astype(np.float32))
    # Those of the neighbouring levels are found too: spacings half and twice as large.
    grid.data.spacing.assign((spacing * rng.choice([0.5, 1.0, 2.0], 400)).astype(np.float32))
    grid.build()
    found = results(near_kernel, 300, [grid.data, column(points, wp.vec3), spacing, spacing], wp.int32)
    distances = np.linalg.norm(points[:, None] - centres[None], axis=2)
    assert np.array_equal(found, (distances < spacing).sum(axis=1))


def test_unused_representatives_are_not_found() -> None:
    grid = Grid(4, CPU)
    grid.data.spacing.assign(np.array([0.1, 0.0, 0.1, 0.0], np.float32))
    grid.build()
    found = results(near_kernel, 1, [grid.data, column([[0.0, 0.0, 0.0]], wp.vec3), 0.1, 1.0], wp.int32)
    assert found.tolist() == [2.0]


def test_distance_along_the_normal_counts_more() -> None:
    offsets = column([[0.3, 0.0, 0.4], [0.0, 0.5, 0.0]], wp.vec3)
    along, across = results(separation_kernel, 2, [CLUSTERING_PARAMETERS, offsets], float)
    assert np.isclose(along, 0.5)
    assert np.isclose(across, 0.5 * STRETCH)

import numpy as np
import warp as wp
from scenes import column, results

from gpu.clustering.grid import CLUSTERING_PARAMETERS, separation
from gpu.lights.disk_grid import CORNERS, LEVELS, DiskGrid, DiskGridBuilder, bucket_at, disk_level, reaches

DISKS, POINTS, REACH = 400, 3000, 0.05
alike = CLUSTERING_PARAMETERS


@wp.func
def inside(place: wp.vec3, position: wp.vec3, normal: wp.vec3, radius: float) -> bool:
    return separation(wp.static(alike), place, normal, position, normal) < radius


@wp.kernel
def found_kernel(first: int, grid: DiskGrid, share: float, places: wp.array[wp.vec3], position: wp.array[wp.vec3],
                 normal: wp.array[wp.vec3], radius: wp.array[float], out: wp.array[wp.vec3i]) -> None:  # fmt: skip
    """Of a place: how many disks the grid tells, how many there are, and how many of a grid's own
    it looks at."""
    index = first + wp.tid()
    told, looked_at, there = int(0), int(0), int(0)
    for level in range(LEVELS):
        bucket = bucket_at(grid, places[index], level, share)
        for place in range(grid.starts[bucket], grid.starts[bucket + 1]):
            disk = grid.entries[place] // CORNERS
            if disk_level(grid, radius[disk] * share, share) == level:
                looked_at += 1
                if reaches(grid, place, places[index]):
                    told += int(inside(places[index], position[disk], normal[disk], radius[disk] * share))
    for disk in range(radius.shape[0]):
        there += int(inside(places[index], position[disk], normal[disk], radius[disk] * share))
    out[index] = wp.vec3i(told, there, looked_at)


def test_a_point_finds_every_disk_that_it_lies_in_once_and_little_else() -> None:
    """Disks of widths from the widest to narrower than the last grid's cells, a third of them far from all others."""
    rng = np.random.default_rng(0)
    position = rng.uniform(-0.5, 0.5, (DISKS, 3)) * np.where(np.arange(DISKS)[:, None] % 3, 0.05, 1.0)
    normal = rng.normal(size=(DISKS, 3))
    normal[::2] = 0.0, 1.0, 0.0
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    radius = REACH * 2.0 ** -rng.uniform(0.0, 9.0, DISKS)
    radius[:4] = REACH
    disks = column(position, wp.vec3), column(normal, wp.vec3), column(radius, wp.float32)
    near = rng.integers(0, DISKS, POINTS)
    places = column(position[near] + 0.7 * radius[near, None] * rng.uniform(-1.0, 1.0, (POINTS, 3)), wp.vec3)
    builder = DiskGridBuilder(DISKS, REACH, float(alike.plane_weight), wp.get_device("cpu"))
    for share in (1.0, 0.6):
        builder.build(*disks, column([share], wp.float32), column([DISKS], wp.int32))
        inputs = [builder.grid, share, places, *disks]
        told, there, looked_at = results(found_kernel, POINTS, inputs, wp.vec3i).T
        assert np.array_equal(told, there)
        assert there.sum() > POINTS // 2
        assert looked_at.mean() < 0.1 * DISKS
    builder.build(*disks, column([1.0], wp.float32), column([0], wp.int32))
    assert not builder.grid.starts.numpy().any()

"""Which of many disks on surfaces a point lies in, as those that photons spread their light over.

Disks are as wide as photons are sparse, so their widths differ by orders of magnitude. Each stands in all cells that it
reaches into of a grid whose cells are one to two times as wide as it is, so in two an axis at most. A point looks at
its own cell of each of a few grids, one after the other, and nearly all that it finds there is near. A hierarchy would
have it go through many nodes for each photon, and through as many where there is none.
"""

import warp as wp

from gpu.clustering.grid import bucket_of, cell_at
from gpu.core.device import launch
from gpu.core.intrinsics import four_at
from gpu.core.radix_sort import Groups

# Grids, each with cells half as wide as those of the one before.
LEVELS = wp.constant(8)
# Cells that a disk may stand in: two an axis.
CORNERS = wp.constant(8)
# Of a grid's cells beside its widest disks, which stand in two of a row at most, whatever is rounded.
CELL_MARGIN = wp.constant(1.001)


@wp.struct
class DiskGrid:
    """reach: of the widest disks, unit space; flatness: how much less a disk reaches along its normal; buckets: in the
    table of all cells, a power of two; entries (place,): disk · CORNERS + corner, grouped by the hash of their cell;
    disks (place,): position and radius of these, side by side as a search reads them; starts (bucket + 1,).
    """

    reach: float
    flatness: float
    buckets: int
    entries: wp.array[int]
    disks: wp.array[wp.vec4]
    starts: wp.array[int]


@wp.func
def disk_level(grid: DiskGrid, radius: float, share: float) -> int:
    """The grid that a disk stands in whose radius is such a share of what it was."""
    return wp.clamp(int(wp.floor(wp.log2(grid.reach * share / radius))), 0, LEVELS - 1)


@wp.func
def cells_a_unit(grid: DiskGrid, level: int, share: float) -> float:
    """How many cells of a grid lie side by side in a unit of length, where disks have a `share` of their radius."""
    return float(1 << level) / (2.0 * CELL_MARGIN * grid.reach * share)


@wp.func
def bucket_of_cell(grid: DiskGrid, cell: wp.vec3i, level: int) -> int:
    """A cell's place in the table; cells side by side have different ones, so no disk is in one twice."""
    block = wp.vec3i(cell[0] >> 1, cell[1] >> 1, cell[2] >> 1)
    within = (cell[0] & 1) | ((cell[1] & 1) << 1) | ((cell[2] & 1) << 2)
    return bucket_of(block, level, grid.buckets // CORNERS) * CORNERS + within


@wp.func
def bucket_at(grid: DiskGrid, position: wp.vec3, level: int, share: float) -> int:
    """The bucket of the cell of a grid that holds a point. There may be disks of other grids in it, and of other cells,
    too.
    """
    return bucket_of_cell(grid, cell_at(position, cells_a_unit(grid, level, share)), level)


@wp.kernel
def disk_key_kernel(first: int, grid: DiskGrid, position: wp.array[wp.vec3], normal: wp.array[wp.vec3],
                    radius: wp.array[float], share: wp.array[float], count: wp.array[int],
                    keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a corner of a disk: the bucket of its cell, keys (disk · CORNERS,); `buckets` for those it does not
    stand in, and for all of them where it has no radius. Of the others: as of DiskGridBuilder.build.
    """
    entry = first + wp.tid()
    disk = entry // CORNERS
    keys[entry] = grid.buckets
    if disk >= count[0] or radius[disk] <= 0.0:
        return
    level = disk_level(grid, radius[disk] * share[0], share[0])
    scale = cells_a_unit(grid, level, share[0])
    extent = wp.vec3(0.0, 0.0, 0.0)
    for axis in range(3):
        along = normal[disk][axis]
        flat = 1.0 - along * along * (1.0 - 1.0 / (grid.flatness * grid.flatness))
        extent[axis] = radius[disk] * share[0] * wp.sqrt(wp.max(flat, 0.0))
    cell = cell_at(position[disk] - extent, scale)
    last = cell_at(position[disk] + extent, scale)
    for axis in range(3):
        if (entry >> axis) & 1 == 1:
            if cell[axis] == last[axis]:
                return
            cell[axis] = cell[axis] + 1
    keys[entry] = bucket_of_cell(grid, cell, level)


@wp.kernel
def disk_entry_kernel(first: int, grid: DiskGrid, position: wp.array[wp.vec3], radius: wp.array[float],
                      share: wp.array[float]) -> None:  # fmt: skip
    """One thread a place among the entries: writes the disk that is there; others: as of DiskGridBuilder.build."""
    place = first + wp.tid()
    if place >= grid.starts[grid.buckets]:
        return
    disk = grid.entries[place] // CORNERS
    p = position[disk]
    grid.disks[place] = wp.vec4(p[0], p[1], p[2], radius[disk] * share[0])


@wp.func
def reaches(grid: DiskGrid, place: int, position: wp.vec3) -> bool:
    """Whether a point is no farther from the disk at a place than that is wide: where that is not so, nothing else of
    the disk need be read.
    """
    disk = four_at(grid.disks, place)
    return wp.length_sq(wp.vec3(disk[0], disk[1], disk[2]) - position) < disk[3] * disk[3]


class DiskGridBuilder:
    """Sorts up to `capacity` disks no wider than `reach` into `grid`. All is allocated once."""

    def __init__(self, capacity: int, reach: float, flatness: float, device: wp.Device) -> None:
        buckets = 1 << max(4 * capacity - 1, int(CORNERS)).bit_length()
        self._groups = Groups(int(CORNERS) * capacity, buckets, device)
        self.grid = DiskGrid()
        self.grid.reach, self.grid.flatness, self.grid.buckets = reach, flatness, buckets
        self.grid.entries, self.grid.starts = self._groups.items, self._groups.starts
        self.grid.disks = wp.zeros(self._groups.capacity, dtype=wp.vec4, device=device)

    def build(self, position: wp.array, normal: wp.array, radius: wp.array, share: wp.array, count: wp.array) -> None:
        """Sort the first `count` (1,) disks in, each with a `share` (1,) of its `radius` (disk,).

        position, normal (disk,): of their centres, unit space.
        """
        groups = self._groups
        inputs = [self.grid, position, normal, radius, share, count, groups.keys]
        launch(disk_key_kernel, groups.capacity, inputs, groups.device)
        groups.sort()
        launch(disk_entry_kernel, groups.capacity, [self.grid, position, radius, share], groups.device)

"""The uniform grid over cluster representatives that nearest-cluster searches walk (2022 paper, Alg. 1, line 5).

Clusters lie densely near the camera and sparsely far away, so one cell size would hold hundreds in a cell here and none
there. Each representative has a spacing, the distance to its neighbours as the view makes it; its cells are the power
of two above that. A search uses one cell size, that of its own point, so a representative stands in the grid at its own
level and the levels beside it. With equal spacings this is the paper's uniform grid. Cells are hashed.
"""

from copy import copy
from dataclasses import dataclass

import warp as wp

from gpu.core.bucket_sort import Buckets
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import four_at
from gpu.core.parameters import parameters
from gpu.sampling.sobol import hashed

# A search uses cells of one level, and a representative stands in those of its own and of one beside it either way.
LEVELS_HELD = wp.constant(3)
# Of cells so small that a spacing of next to nothing has one, and that unit space has a whole number of them.
MIN_LEVEL = wp.constant(-24)


@wp.struct
@dataclass
class ClusteringParameters:
    """What surface points count as near and alike (2022 paper, Eq. 7).

    normal_threshold: alike are points whose normals' cosine is more than this (30°); relaxed_threshold: where a search
    that widens found none of those. plane_weight: how much more a distance along the normal counts than one along the
    surface, which keeps shelves and slats apart. cell_per_spacing: cells are the power of two above so many spacings;
    wider_levels: that a search which widens tries, of cells twice as large each, before it relaxes the threshold.
    """

    normal_threshold: float = 0.8660254
    relaxed_threshold: float = 0.0
    plane_weight: float = 8.0
    cell_per_spacing: float = 1.5
    wider_levels: int = 3


CLUSTERING_PARAMETERS: ClusteringParameters = parameters(ClusteringParameters)


@wp.struct
class Representatives:
    """The clusters' points. position, normal, spacing (cluster,); spacing ≤ 0 marks a cluster that is not in use.

    chosen: what is near and alike.
    level (cluster,): the grid's, by spacing; entries: (position, cluster), then (normal, level) of each level of each
    representative, side by side as a search reads them, grouped by the hash of their cell, numbers as floats, which are
    exact below 2²⁴; starts (bucket + 1,): in such pairs.
    """

    chosen: ClusteringParameters
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    spacing: wp.array[float]
    level: wp.array[int]
    entries: wp.array[wp.vec4]
    starts: wp.array[int]
    buckets: int


@wp.func
def level_of(chosen: ClusteringParameters, spacing: float) -> int:
    """The grid level for points so far apart: that whose cells are the power of two next above some spacings."""
    return wp.max(int(wp.ceil(wp.log2(chosen.cell_per_spacing * spacing))), MIN_LEVEL)


@wp.func
def cells_per_unit(level: int) -> float:
    """How many cells of a level lie side by side in a unit of length."""
    return wp.pow(2.0, -float(level))


@wp.func
def cell_at(position: wp.vec3, scale: float) -> wp.vec3i:
    """The cell that holds `position` where there are `scale` cells per unit."""
    scaled = position * scale
    return wp.vec3i(int(wp.floor(scaled[0])), int(wp.floor(scaled[1])), int(wp.floor(scaled[2])))


@wp.func
def bucket_of(cell: wp.vec3i, level: int, buckets: int) -> int:
    """A cell's place in a table of `buckets`, a power of two."""
    mixed = hashed(wp.uint32(cell[0]) ^ hashed(wp.uint32(cell[1]) ^ hashed(wp.uint32(cell[2]) ^ wp.uint32(level))))
    return int(mixed & wp.uint32(buckets - 1))


@wp.func
def separation(chosen: ClusteringParameters, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> float:
    """Distance of two surface points with what lies along the normals stretched; Eq. 7 without its threshold."""
    offset = q - p
    plane = wp.max(wp.abs(wp.dot(offset, p_normal)), wp.abs(wp.dot(offset, q_normal)))
    return wp.sqrt(wp.length_sq(offset) + (chosen.plane_weight * chosen.plane_weight - 1.0) * plane * plane)


@wp.kernel
def grid_key_kernel(first: int, clusters: Representatives, keys: wp.array[int]) -> None:
    """One thread an entry: the bucket of one level of one representative, `buckets` when it is not in use."""
    entry = first + wp.tid()
    cluster = entry // LEVELS_HELD
    spacing = clusters.spacing[cluster]
    if spacing <= 0.0:
        keys[entry] = clusters.buckets
        return
    own = level_of(clusters.chosen, spacing)
    if entry % LEVELS_HELD == 0:
        clusters.level[cluster] = own
    level = own + entry % LEVELS_HELD - 1
    cell = cell_at(clusters.position[cluster], cells_per_unit(level))
    keys[entry] = bucket_of(cell, level, clusters.buckets)


@wp.kernel
def grid_entry_kernel(first: int, items: wp.array[int], clusters: Representatives) -> None:
    """One thread a place among the entries: writes the one that is there. items: as of grid_key_kernel, sorted."""
    place = first + wp.tid()
    if place >= clusters.starts[clusters.buckets]:
        return
    cluster = items[place] // LEVELS_HELD
    level = clusters.level[cluster] + items[place] % LEVELS_HELD - 1
    p = clusters.position[cluster]
    n = clusters.normal[cluster]
    clusters.entries[2 * place] = wp.vec4(p[0], p[1], p[2], float(cluster))
    clusters.entries[2 * place + 1] = wp.vec4(n[0], n[1], n[2], float(level))


@wp.struct
class Entry:
    """One representative in one of its cells."""

    position: wp.vec3
    cluster: int
    normal: wp.vec3
    level: int


@wp.func
def entry_at(clusters: Representatives, place: int) -> Entry:
    """One of the entries."""
    one = four_at(clusters.entries, 2 * place)
    two = four_at(clusters.entries, 2 * place + 1)
    entry = Entry()
    entry.position = wp.vec3(one[0], one[1], one[2])
    entry.cluster = int(one[3])
    entry.normal = wp.vec3(two[0], two[1], two[2])
    entry.level = int(two[3])
    return entry


class Grid:
    """The grid over up to `capacity` representatives; `data` is what kernels take."""

    def __init__(self, capacity: int, device: wp.Device, chosen: ClusteringParameters = CLUSTERING_PARAMETERS) -> None:
        self.capacity, self.device, self._chosen = capacity, device, chosen
        entries = LEVELS_HELD * capacity
        self._buckets = Buckets(entries, 1 << (entries - 1).bit_length(), device)
        self.data = self._allocate()

    def with_own_data(self) -> "Grid":
        """A grid over other representatives; both share what `build` only works with, so they build one by one."""
        other = copy(self)
        other._buckets = copy(self._buckets)
        other._buckets.starts = wp.zeros_like(self._buckets.starts)
        other.data = other._allocate()
        return other

    def _allocate(self) -> Representatives:
        data: Representatives = allocate(Representatives, self.capacity, self.device)
        data.chosen = self._chosen
        data.entries = wp.zeros(2 * self._buckets.capacity, dtype=wp.vec4, device=self.device)
        data.starts, data.buckets = self._buckets.starts, len(self._buckets.starts) - 1
        return data

    def build(self) -> None:
        """Sort the representatives now in `data` into cells."""
        launch(grid_key_kernel, self._buckets.capacity, [self.data, self._buckets.keys], self.device)
        self._buckets.sort()
        launch(grid_entry_kernel, self._buckets.capacity, [self._buckets.items, self.data], self.device)

"""What VPLs know of the radiosity around them, and the look-up of one that answers for a point: near-field light's.

That a look-up finds just one is P. Christensen's (Faster Photon Map Global Illumination, 1999). Radiosity is found by
gpu.vpl.radiosity_estimate.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import ClusteringParameters, cell_at, cells_per_unit, level_of, separation
from gpu.core.device import launch, launch_together
from gpu.core.morton import dominant_axis
from gpu.core.parameters import parameters
from gpu.core.radix_sort import Groups
from gpu.sampling.sobol import hashed

# A VPL stands in cells of so many sizes, each twice the one before: entries are encoded by their number.
LEVELS_HELD = wp.constant(3)
# Of cells wider than any scene: where no VPL knows anything.
NO_LEVEL = 32
# Cells are moved by so much, or walls would lie between them, those that bound unit space in all levels, and rounding
# would decide in which a point is.
CELLS_MOVED = wp.constant(wp.vec3(0.21371, 0.17317, 0.13193))


@wp.struct
@dataclass
class RadiosityParameters:
    """What decides the quality of estimates and of their look-up.

    plane_share: of the disk's radius; VPLs farther off the plane are of another surface. They bound the disk all the
    same, which is so no wider than slats are apart. most_area: neighbours are searched for no farther than if all VPLs
    lay evenly on so many unit squares. least_covered: of the PLACES; fewer that are surface are not believed, and
    near-field rays go on from there (gpu.indirect.near_field_paths).
    reach: a VPL answers for points within so many of its radii, stretched along the normals. cell_share: of radii, in
    spacings of gpu.clustering.grid: the smallest cell of a VPL has 0.75 to 1.5 radii, so that in its cells 2 to 140
    VPLs of a surface are about, of which a look-up reads most_read. levels_searched: what few VPLs far around say of a
    crack is noise. most_of_mean: the strongest VPL of an estimate counts as so many of the others at most: one that
    came a way few paths go would make a bright spot of what is a wide faint glow.
    """

    plane_share: float = 0.25
    most_area: float = 16.0
    least_covered: int = 3
    reach: float = 2.0
    cell_share: float = 0.5
    most_read: int = 12
    levels_searched: int = 9
    most_of_mean: float = 4.0


RADIOSITY_PARAMETERS: RadiosityParameters = parameters(RadiosityParameters)


@wp.struct
class RadiosityCache:
    """VPLs that know the radiosity around them, in hashed cells, each of one size and of normals to one side.

    chosen: how it is made and read; alike: which points are. position, normal (vpl,); radius (vpl,): of the estimate's
    disk, 0 for none; radiosity (vpl,) [W/m²]; reflectance (vpl,): of its surface, where lobes read the cache; covered
    (vpl,): how many of the PLACES around are surface; usual_area: of a VPL, if all lay evenly on `most_area`.
    entries: encoded LEVELS_HELD·vpl + (level − own level), grouped by bucket; starts (bucket + 1,); lowest, highest
    (1,): the levels that entries have, NO_LEVEL and −1 where there is none.
    """

    chosen: RadiosityParameters
    alike: ClusteringParameters
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    radius: wp.array[float]
    radiosity: wp.array[wp.vec3]
    reflectance: wp.array[wp.vec3]
    covered: wp.array[int]
    entries: wp.array[int]
    starts: wp.array[int]
    usual_area: float
    buckets: int
    lowest: wp.array[int]
    highest: wp.array[int]


@wp.func
def is_narrow(lit: RadiosityCache, vpl: int) -> bool:
    """Whether so few places around a VPL are surface that how densely VPLs lie there tells little."""
    return lit.covered[vpl] < lit.chosen.least_covered


@wp.func
def bucket_around(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, level: int) -> int:
    """The place in the table of the cell of a level that holds a surface point. Cells may share one."""
    cell = cell_at(position + CELLS_MOVED, cells_per_unit(level))
    mixed = hashed(wp.uint32(6 * level + dominant_axis(normal)))
    for axis in range(3):
        mixed = hashed(mixed ^ wp.uint32(cell[axis]))
    return int(mixed & wp.uint32(lit.buckets - 1))


@wp.kernel
def radiosity_bucket_kernel(first: int, lit: RadiosityCache, buckets: wp.array[int]) -> None:
    """One thread an entry: its bucket, or `buckets` of the map where the VPL knows nothing."""
    entry = first + wp.tid()
    vpl = entry // LEVELS_HELD
    buckets[entry] = lit.buckets
    if lit.radius[vpl] > 0.0:
        level = level_of(lit.alike, lit.chosen.cell_share * lit.radius[vpl]) + entry % LEVELS_HELD
        buckets[entry] = bucket_around(lit, lit.position[vpl], lit.normal[vpl], level)


@wp.kernel
def radiosity_level_kernel(first: int, lit: RadiosityCache) -> None:
    """One thread a VPL: widens the levels that entries have by its own, if it knows something."""
    radius = lit.radius[first + wp.tid()]
    if radius > 0.0:
        level = level_of(lit.alike, lit.chosen.cell_share * radius)
        if level < lit.lowest[0]:
            wp.atomic_min(lit.lowest, 0, level)
        if level + LEVELS_HELD - 1 > lit.highest[0]:
            wp.atomic_max(lit.highest, 0, level + LEVELS_HELD - 1)


class RadiosityCells:
    """The cells of a cache, which it makes for its VPLs; their arrays are allocated once."""

    def __init__(self, lit: RadiosityCache, device: wp.Device, usual: int = 0) -> None:
        """usual: about how many VPLs there are, if fewer than there is room for: look-ups depend on it."""
        self._lit, entries = lit, LEVELS_HELD * len(lit.radius)
        lit.buckets = 1 << (LEVELS_HELD * (usual or len(lit.radius)) - 1).bit_length()
        lit.lowest, lit.highest = (wp.zeros(1, dtype=int, device=device) for _ in range(2))
        self._groups = Groups(entries, lit.buckets, device)
        lit.entries, lit.starts = self._groups.items, self._groups.starts

    def sort(self) -> None:
        """Sort the VPLs into cells by their radii."""
        lit, groups = self._lit, self._groups
        lit.lowest.fill_(NO_LEVEL)
        lit.highest.fill_(-1)
        launch_together(radiosity_level_kernel, len(lit.radius), [lit], groups.device)
        launch(radiosity_bucket_kernel, groups.capacity, [lit, groups.keys], groups.device)
        groups.sort()


@wp.func
def answering_vpl(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, first_level: int, end_level: int) -> int:
    """The VPL that answers for a surface point, of the first level from `first_level` on that knows one; −1 for none.

    All VPLs in a cell are of similar use, so it is enough to look at a few, that are spread evenly over their order,
    which follows the clusters.
    """
    vpl = int(-1)
    level = wp.max(first_level, lit.lowest[0])
    last_level = wp.min(end_level, lit.highest[0] + 1)
    while vpl < 0 and level < last_level:
        bucket = bucket_around(lit, position, normal, level)
        begin = lit.starts[bucket]
        end = lit.starts[bucket + 1]
        step = (end - begin + lit.chosen.most_read - 1) // lit.chosen.most_read
        best = lit.chosen.reach
        place = begin
        while place < end:
            candidate = lit.entries[place] // LEVELS_HELD
            candidate_normal = lit.normal[candidate]
            if wp.dot(candidate_normal, normal) > lit.alike.normal_threshold:
                away = separation(lit.alike, position, normal, lit.position[candidate], candidate_normal)
                away = away / lit.radius[candidate]
                if away < best:
                    best = away
                    vpl = candidate
            place += step
        level += 1
    return vpl


@wp.func
def vpl_around(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, scale: float) -> int:
    """The VPL that answers for a surface point, −1 where none is near; of radii far from `scale`, none is found."""
    level = level_of(lit.alike, scale)
    return answering_vpl(lit, position, normal, level, level + lit.chosen.levels_searched)


@wp.func
def lacking_area(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3, scale: float) -> float:
    """The area of a VPL about a surface point, were there one, where `vpl_around` finds none for `scale`; 0 where VPLs
    lie, but densely.
    """
    if answering_vpl(lit, position, normal, lit.lowest[0], level_of(lit.alike, scale)) >= 0:
        return 0.0
    return lit.usual_area

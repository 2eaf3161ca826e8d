"""Clusters of the VPLs of reflective shadow maps, kept from frame to frame: Algorithm 1 of the 2012 paper.

One round a frame: clusters of the frame before, of which those that lost all members start again where VPLs matter,
take the VPLs that are most like them by Eq. 1 among those near in the maps, and move to their means. Beyond the paper:
a pixel that finds no cluster within r cells looks farther, so that no light is lost.
"""

from dataclasses import dataclass
from math import ceil, sqrt

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import lanes_of, vector_sum
from gpu.core.parameters import parameters
from gpu.core.radix_sort import Groups, iota_kernel
from gpu.lights.light_paths import Vpls, surface_key_kernel
from gpu.lights.reflective_shadow_map import ShadowMaps, atlas_place


@wp.struct
@dataclass
class ShadowMapClusterParameters:
    """The weights of Eq. 1, w_d per unit space squared, w_n and w_Φ, and r: how many cells away clusters are searched
    for.
    """

    distance: float = 100.0
    normal: float = 10.0
    flux: float = 1.0
    reach: int = 2


SHADOW_MAP_CLUSTER_PARAMETERS: ShadowMapClusterParameters = parameters(ShadowMapClusterParameters)


@wp.struct
class MapClusters:
    """Clusters of a viewer's frame, (cluster,) each, in Morton's order of where they began.

    position, normal, place: flux-weighted means of members, place that in the atlas; flux: their sum [W]; members: how
    many there are, 0 for one that is to start again.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    place: wp.array[wp.vec2]
    flux: wp.array[wp.vec3]
    members: wp.array[int]


@wp.struct
class MapGrid:
    """Clusters by cell of `side`² over the atlas: items[starts[cell] : starts[cell + 1]], cells row by row."""

    side: int
    items: wp.array[int]
    starts: wp.array[int]


@wp.func
def difference(chosen: ShadowMapClusterParameters, vpls: Vpls, vpl: int, clusters: MapClusters, cluster: int) -> float:
    """How unlike a VPL and a cluster are: μ of Eq. 1."""
    off = vpls.position[vpl] - clusters.position[cluster]
    turned = 1.0 - wp.dot(vpls.normal[vpl], clusters.normal[cluster])
    color = wp.normalize(vpls.flux[vpl]) - wp.normalize(clusters.flux[cluster])
    return chosen.distance * wp.length_sq(off) + chosen.normal * turned + chosen.flux * wp.length_sq(color)


@wp.kernel
def start_clusters_kernel(
    first: int, vpls: Vpls, maps: ShadowMaps, seeds: wp.array[int], begins: bool, clusters: MapClusters
) -> None:
    """One thread a cluster: starts it at the VPL of its seed if it has no members, or if all are to begin anew."""
    cluster = first + wp.tid()
    if clusters.members[cluster] > 0 and not begins:
        return
    clusters.flux[cluster] = wp.vec3(0.0, 0.0, 0.0)
    seed = seeds[cluster]
    if seed >= 0:
        clusters.position[cluster] = vpls.position[seed]
        clusters.normal[cluster] = vpls.normal[seed]
        clusters.flux[cluster] = vpls.flux[seed]
        clusters.place[cluster] = atlas_place(maps, seed)


@wp.func
def row_of(coordinate: float, side: int) -> int:
    """The row or column of cells that holds a coordinate."""
    return wp.clamp(int(coordinate * float(side)), 0, side - 1)


@wp.kernel
def cluster_cell_kernel(first: int, clusters: MapClusters, grid: MapGrid, keys: wp.array[int]) -> None:
    """One thread a cluster: its cell, side² for one without flux, which is nothing's like."""
    cluster = first + wp.tid()
    keys[cluster] = grid.side * grid.side
    if brightness(clusters.flux[cluster]) > 0.0:
        place = clusters.place[cluster]
        keys[cluster] = row_of(place[1], grid.side) * grid.side + row_of(place[0], grid.side)


@wp.kernel
def assign_to_clusters_kernel(first: int, vpls: Vpls, maps: ShadowMaps, clusters: MapClusters, grid: MapGrid,
                              chosen: ShadowMapClusterParameters, keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel: keys[pixel] becomes the most like of the clusters near it, their number where it is dark."""
    pixel = first + wp.tid()
    keys[pixel] = clusters.members.shape[0]
    if brightness(vpls.flux[pixel]) <= 0.0:
        return
    place = atlas_place(maps, pixel)
    column = row_of(place[0], grid.side)
    row = row_of(place[1], grid.side)
    best = int(-1)
    least = float(FAR_AWAY)
    reach = int(chosen.reach)
    while best < 0:
        left = wp.max(column - reach, 0)
        right = wp.min(column + reach, grid.side - 1)
        for near in range(wp.max(row - reach, 0), wp.min(row + reach, grid.side - 1) + 1):
            cells = near * grid.side
            for entry in range(grid.starts[cells + left], grid.starts[cells + right + 1]):
                cluster = grid.items[entry]
                unlike = difference(chosen, vpls, pixel, clusters, cluster)
                if unlike < least or (unlike == least and cluster < best):
                    least = unlike
                    best = cluster
        if reach >= grid.side:
            break
        reach = 2 * reach
    if best >= 0:
        keys[pixel] = best


@wp.kernel
def move_clusters_kernel(first: int, vpls: Vpls, maps: ShadowMaps, items: wp.array[int], starts: wp.array[int],
                         lanes: int, clusters: MapClusters) -> None:  # fmt: skip
    """`lanes` threads a cluster: moves it to its members' means by flux; one without members stays where it is.

    items, starts: members of each.
    """
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    position = wp.vec3(0.0, 0.0, 0.0)
    normal = wp.vec3(0.0, 0.0, 0.0)
    flux = wp.vec3(0.0, 0.0, 0.0)
    place = wp.vec3(0.0, 0.0, 0.0)
    for entry in range(starts[cluster] + lane, starts[cluster + 1], lanes):
        vpl = items[entry]
        weight = brightness(vpls.flux[vpl])
        at = atlas_place(maps, vpl)
        position += vpls.position[vpl] * weight
        normal += vpls.normal[vpl] * weight
        flux += vpls.flux[vpl]
        place += wp.vec3(at[0], at[1], 1.0) * weight
    position = vector_sum(position, lanes)
    normal = vector_sum(normal, lanes)
    flux = vector_sum(flux, lanes)
    place = vector_sum(place, lanes)
    if lane != 0:
        return
    clusters.members[cluster] = starts[cluster + 1] - starts[cluster]
    if clusters.members[cluster] > 0:
        clusters.position[cluster] = position / place[2]
        clusters.place[cluster] = wp.vec2(place[0], place[1]) / place[2]
        clusters.flux[cluster] = flux
        if wp.length_sq(normal) > 0.0:
            clusters.normal[cluster] = wp.normalize(normal)


@wp.kernel
def map_medoid_kernel(first: int, vpls: Vpls, clusters: MapClusters, chosen: ShadowMapClusterParameters,
                      items: wp.array[int], starts: wp.array[int], medoids: wp.array[int]) -> None:  # fmt: skip
    """One thread a cluster: the member that is most like its means, −1 if there is none: these may lie in no surface.

    items, starts: members of each.
    """
    cluster = first + wp.tid()
    best = int(-1)
    least = float(FAR_AWAY)
    for entry in range(starts[cluster], starts[cluster + 1]):
        unlike = difference(chosen, vpls, items[entry], clusters, cluster)
        if unlike < least:
            least = unlike
            best = items[entry]
    medoids[cluster] = best


class ShadowMapClustering:
    """Rounds of clustering of the pixels of `maps` into `count` clusters; what it works with is allocated once.

    After `run`: `groups` has each cluster's members, neighbours on a surface side by side, and `medoids` (cluster,)
    those that represent them, −1 for none.
    seeds (cluster,): the pixels where clusters start, ascending; the caller writes the first `count`, in any order.
    """

    def __init__(self, maps: ShadowMaps, count: int, device: wp.Device,
                 chosen: ShadowMapClusterParameters = SHADOW_MAP_CLUSTER_PARAMETERS) -> None:  # fmt: skip
        self.maps, self.count, self.device, self.chosen = maps, count, device, chosen
        # √k × √k cells over what there is of the atlas.
        used = maps.count / (maps.atlas_side / maps.side) ** 2
        side = ceil(sqrt(count / used))
        self._cells = Groups(count, side * side, device)
        self.grid = MapGrid()
        self.grid.side, self.grid.items, self.grid.starts = side, self._cells.items, self._cells.starts
        self.groups = Groups(maps.count * maps.side**2, count, device)
        self._order, self._order_keys = (wp.zeros(2 * self.groups.capacity, dtype=int, device=device) for _ in range(2))
        self.seeds = wp.zeros(2 * count, dtype=int, device=device)
        self._seed_order = wp.zeros(2 * count, dtype=int, device=device)
        self.medoids = wp.zeros(count, dtype=int, device=device)

    def new_clusters(self) -> MapClusters:
        """Clusters of a viewer that has none yet."""
        clusters: MapClusters = allocate(MapClusters, self.count, self.device)
        return clusters

    def run(self, vpls: Vpls, clusters: MapClusters, *, begins: bool) -> None:
        """One round of `clusters` over `vpls`, a pixel each; begins: all start anew."""
        groups, maps, chosen, device = self.groups, self.maps, self.chosen, self.device
        radix_sort_pairs(self.seeds, self._seed_order, self.count)
        launch(start_clusters_kernel, self.count, [vpls, maps, self.seeds, begins, clusters], device)
        launch(cluster_cell_kernel, self.count, [clusters, self.grid, self._cells.keys], device)
        self._cells.sort()
        inputs = [vpls, maps, clusters, self.grid, chosen, groups.keys]
        launch(assign_to_clusters_kernel, groups.capacity, inputs, device)
        self._put_in_order(vpls)
        groups.sort(self._order)
        members, lanes = [groups.items, groups.starts], lanes_of(device, few=True)
        launch(move_clusters_kernel, lanes * self.count, [vpls, maps, *members, lanes, clusters], device)
        launch(map_medoid_kernel, self.count, [vpls, clusters, chosen, *members, self.medoids], device)

    def _put_in_order(self, vpls: Vpls) -> None:
        """Neighbours on a surface side by side: those in a map may be far apart, of a light that has an extent."""
        order, keys, capacity = self._order, self._order_keys, self.groups.capacity
        launch(surface_key_kernel, capacity, [vpls.position, vpls.normal, vpls.flux, keys], self.device)
        launch(iota_kernel, capacity, [order], self.device)
        radix_sort_pairs(keys, order, capacity)

"""Clusters of the VPLs of reflective shadow maps, whose seeds are kept from frame to frame: Algorithm 1 of the 2012
paper.

One round a frame: clusters start at their seeds, take the VPLs that are most like them by Eq. 1, and move to their
means. The paper starts a frame with the means of the one before, which settle round after round and come after a light
that moves. Seeds are pixels, which go along with their light; each is chosen anew once in a while, where VPLs matter by
then. The paper looks for clusters in cells of one map about a VPL's own, which finds those that are near where that map
is of a light without extent. Maps of several lights, and of wide ones, show one place at many pixels: all clusters are
looked at here.
"""

from dataclasses import dataclass

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import four_at, lanes_of, place_of_least, vector_sum
from gpu.core.morton import morton_key
from gpu.core.parameters import parameters
from gpu.core.radix_sort import Groups, iota_kernel
from gpu.lights.light_paths import Vpls
from gpu.lights.path_ends import surface_key_kernel
from gpu.lights.reflective_shadow_map import ShadowMaps


@wp.struct
@dataclass
class ShadowMapClusterParameters:
    """The weights of Eq. 1, w_d per unit space squared, w_n and w_Φ; frames: that a seed is kept for."""

    distance: float = 100.0
    normal: float = 10.0
    flux: float = 1.0
    frames: int = 32


SHADOW_MAP_CLUSTER_PARAMETERS: ShadowMapClusterParameters = parameters(ShadowMapClusterParameters)


@wp.struct
class Traits:
    """What VPLs and clusters are like or unlike by; color: of unit length, as flux is mixed of channels; worth: of the
    map (ShadowMaps).
    """

    position: wp.vec3
    normal: wp.vec3
    color: wp.vec3
    worth: float


@wp.struct
class KeptSeeds:
    """Where clusters of a viewer's walk start: pixels (cluster,); ages (cluster,): for how many frames they did."""

    pixels: wp.array[int]
    ages: wp.array[int]


@wp.struct
class MapClusters:
    """Clusters of a frame in Morton's order of their places.

    traits (3 · cluster,): flux-weighted means of members' Traits, side by side as a search reads them; members
    (cluster,): how many there are.
    """

    traits: wp.array[wp.vec4]
    members: wp.array[int]


@wp.func
def traits_at(clusters: MapClusters, cluster: int) -> Traits:
    """Those of one of the clusters."""
    one = four_at(clusters.traits, 3 * cluster)
    two = four_at(clusters.traits, 3 * cluster + 1)
    three = four_at(clusters.traits, 3 * cluster + 2)
    traits = Traits()
    traits.position = wp.vec3(one[0], one[1], one[2])
    traits.normal = wp.vec3(two[0], two[1], two[2])
    traits.color = wp.vec3(three[0], three[1], three[2])
    traits.worth = one[3]
    return traits


@wp.func
def set_traits(clusters: MapClusters, cluster: int, traits: Traits) -> None:
    """Has them be those of a cluster."""
    p = traits.position
    n = traits.normal
    c = traits.color
    clusters.traits[3 * cluster] = wp.vec4(p[0], p[1], p[2], traits.worth)
    clusters.traits[3 * cluster + 1] = wp.vec4(n[0], n[1], n[2], 0.0)
    clusters.traits[3 * cluster + 2] = wp.vec4(c[0], c[1], c[2], 0.0)


@wp.func
def traits_of(vpls: Vpls, maps: ShadowMaps, vpl: int) -> Traits:
    """Those of a VPL, a pixel of `maps`."""
    traits = Traits()
    traits.position = vpls.position[vpl]
    traits.normal = vpls.normal[vpl]
    traits.color = wp.normalize(vpls.flux[vpl])
    traits.worth = maps.worth[vpl // (maps.side * maps.side)]
    return traits


@wp.func
def difference(chosen: ShadowMapClusterParameters, one: Traits, other: Traits) -> float:
    """How unlike a VPL and a cluster are: μ of Eq. 1."""
    off = wp.length_sq(one.position - other.position)
    turned = 1.0 - wp.dot(one.normal, other.normal)
    return chosen.distance * off + chosen.normal * turned + chosen.flux * wp.length_sq(one.color - other.color)


@wp.kernel
def start_clusters_kernel(first: int, vpls: Vpls, maps: ShadowMaps, seeds: wp.array[int], begins: bool,
                          frames: int, kept: KeptSeeds, started: MapClusters, keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a cluster: starts it at its seed, which is kept unless it is dark now, old, or all are to begin anew.

    Those that begin have ages that are spread evenly; keys (cluster,): its place in Morton's order.
    """
    cluster = first + wp.tid()
    seed = seeds[cluster]
    age = kept.ages[cluster] + 1
    if begins:
        age = cluster % frames
    if seed >= 0 and (begins or age >= frames or brightness(vpls.flux[kept.pixels[cluster]]) <= 0.0):
        kept.pixels[cluster] = seed
        age = wp.where(begins, age, 0)
    kept.ages[cluster] = age
    traits = traits_of(vpls, maps, kept.pixels[cluster])
    set_traits(started, cluster, traits)
    keys[cluster] = morton_key(traits.position, traits.normal)


@wp.kernel
def order_clusters_kernel(first: int, started: MapClusters, order: wp.array[int], clusters: MapClusters) -> None:
    """One thread a cluster: copies the one that comes there in `order`."""
    cluster = first + wp.tid()
    set_traits(clusters, cluster, traits_at(started, order[cluster]))


@wp.kernel(module="unique", module_options={"fast_math": True})
def assign_to_clusters_kernel(first: int, vpls: Vpls, maps: ShadowMaps, clusters: MapClusters,
                              chosen: ShadowMapClusterParameters, lanes: int,
                              keys: wp.array[int]) -> None:  # fmt: skip
    """`lanes` threads a pixel: keys[pixel] becomes the most like of the clusters of maps that are worth as much, the
    number of clusters where it is dark or there is none.

    A roof in the sun would be like the ceiling of a closed room below it, and have its light in there.
    """
    index = first + wp.tid()
    pixel = index // lanes
    lane = index % lanes
    count = clusters.members.shape[0]
    if brightness(vpls.flux[pixel]) <= 0.0:
        keys[pixel] = count
        return
    traits = traits_of(vpls, maps, pixel)
    best = int(count)
    least = float(FAR_AWAY)
    for cluster in range(lane, count, lanes):
        other = traits_at(clusters, cluster)
        unlike = difference(chosen, traits, other)
        if unlike < least and other.worth == traits.worth:
            least = unlike
            best = cluster
    best = place_of_least(least, best, lanes)
    if lane == 0:
        keys[pixel] = best


@wp.kernel
def move_clusters_kernel(first: int, vpls: Vpls, items: wp.array[int], starts: wp.array[int], lanes: int,
                         clusters: MapClusters) -> None:  # fmt: skip
    """`lanes` threads a cluster: moves it to its members' means by flux; one without members stays at its seed.

    items, starts: members of each.
    """
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    position = wp.vec3(0.0, 0.0, 0.0)
    normal = wp.vec3(0.0, 0.0, 0.0)
    flux = wp.vec3(0.0, 0.0, 0.0)
    for entry in range(starts[cluster] + lane, starts[cluster + 1], lanes):
        vpl = items[entry]
        weight = brightness(vpls.flux[vpl])
        position += vpls.position[vpl] * weight
        normal += vpls.normal[vpl] * weight
        flux += vpls.flux[vpl]
    position = vector_sum(position, lanes)
    normal = vector_sum(normal, lanes)
    flux = vector_sum(flux, lanes)
    if lane != 0:
        return
    clusters.members[cluster] = starts[cluster + 1] - starts[cluster]
    if clusters.members[cluster] > 0:
        traits = traits_at(clusters, cluster)
        traits.position = position / brightness(flux)
        traits.normal = wp.normalize(normal)
        traits.color = wp.normalize(flux)
        set_traits(clusters, cluster, traits)


@wp.kernel
def map_medoid_kernel(first: int, vpls: Vpls, maps: ShadowMaps, clusters: MapClusters,
                      chosen: ShadowMapClusterParameters, items: wp.array[int], starts: wp.array[int],
                      lanes: int, medoids: wp.array[int]) -> None:  # fmt: skip
    """`lanes` threads a cluster: the member that is most like its means, −1 if there is none: these may lie in no
    surface.

    items, starts: members of each.
    """
    index = first + wp.tid()
    cluster = index // lanes
    lane = index % lanes
    traits = traits_at(clusters, cluster)
    best = int(-1)
    least = float(FAR_AWAY)
    for entry in range(starts[cluster] + lane, starts[cluster + 1], lanes):
        unlike = difference(chosen, traits_of(vpls, maps, items[entry]), traits)
        if unlike < least:
            least = unlike
            best = entry
    best = place_of_least(least, best, lanes)
    if lane == 0:
        medoids[cluster] = -1
        if best >= 0:
            medoids[cluster] = items[best]


class ShadowMapClustering:
    """Rounds of clustering of the pixels of `maps` into `count` clusters; what it works with is allocated once.

    After `run`: `clusters`, `groups` has each one's members, neighbours on a surface side by side, and `medoids`
    (cluster,) those that represent them, −1 for none. seeds (cluster,): the pixels where clusters would start if all
    began anew, which the caller writes.
    """

    def __init__(self, maps: ShadowMaps, count: int, device: wp.Device,
                 chosen: ShadowMapClusterParameters = SHADOW_MAP_CLUSTER_PARAMETERS) -> None:  # fmt: skip
        self._maps, self.count, self.device, self.chosen = maps, count, device, chosen
        capacity = maps.count * maps.side**2
        self.groups = Groups(capacity, count, device)
        self.seeds = wp.zeros(count, dtype=int, device=device)
        self.medoids = wp.zeros(count, dtype=int, device=device)
        self.clusters, self._started = self._new_clusters(), self._new_clusters()
        self._keys, self._order = (wp.zeros(2 * count, dtype=int, device=device) for _ in range(2))
        self._pixel_keys, self._pixels = (wp.zeros(2 * capacity, dtype=int, device=device) for _ in range(2))

    def new_seeds(self) -> KeptSeeds:
        """Seeds of a viewer that has none yet."""
        seeds: KeptSeeds = allocate(KeptSeeds, self.count, self.device)
        return seeds

    def _new_clusters(self) -> MapClusters:
        clusters: MapClusters = allocate(MapClusters, self.count, self.device)
        clusters.traits = wp.zeros(3 * self.count, dtype=wp.vec4, device=self.device)
        return clusters

    def run(self, vpls: Vpls, kept: KeptSeeds, *, begins: bool) -> None:
        """One round over `vpls`, a pixel each, from the seeds that are `kept`; begins: all start anew."""
        groups, maps, chosen, device, clusters = self.groups, self._maps, self.chosen, self.device, self.clusters
        inputs = [vpls, maps, self.seeds, begins, chosen.frames, kept, self._started, self._keys]
        launch(start_clusters_kernel, self.count, inputs, device)
        self._sort(self._keys, self._order, self.count)
        launch(order_clusters_kernel, self.count, [self._started, self._order, clusters], device)
        lanes = lanes_of(device, few=True)
        inputs = [vpls, maps, clusters, chosen, lanes, groups.keys]
        launch(assign_to_clusters_kernel, lanes * groups.capacity, inputs, device)
        inputs = [vpls.position, vpls.normal, vpls.flux, self._pixel_keys]
        launch(surface_key_kernel, groups.capacity, inputs, device)
        self._sort(self._pixel_keys, self._pixels, groups.capacity)
        groups.sort(self._pixels)
        members = [groups.items, groups.starts, lanes]
        launch(move_clusters_kernel, lanes * self.count, [vpls, *members, clusters], device)
        launch(map_medoid_kernel, lanes * self.count, [vpls, maps, clusters, chosen, *members, self.medoids], device)

    def _sort(self, keys: wp.array, order: wp.array, count: int) -> None:
        launch(iota_kernel, count, [order], self.device)
        radix_sort_pairs(keys, order, count)

"""VPLs of shadow maps that are made by hand, and clusters of them."""

import numpy as np
import warp as wp
from scenes import column

from gpu.core.morton import morton_order
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.lights.reflective_shadow_map import ShadowMaps
from gpu.scene.types import Doubles, Ints
from gpu.vpl.shadow_map_clusters import (
    SHADOW_MAP_CLUSTER_PARAMETERS,
    KeptSeeds,
    ShadowMapClustering,
    ShadowMapClusterParameters,
)

CPU = wp.get_device("cpu")
SIDE, COUNT = 32, 64


def maps_of(count: int = 1) -> ShadowMaps:
    maps = ShadowMaps()
    maps.count, maps.side, maps.atlas_side = count, SIDE, SIDE
    while (maps.atlas_side // SIDE) ** 2 < count:
        maps.atlas_side *= 2
    maps.worth = wp.full(count, 1.0, dtype=float, device=CPU)
    return maps


def places(maps: ShadowMaps) -> Doubles:
    """Where the pixels are in the atlas, (pixel, 2)."""
    side = maps.atlas_side
    order = morton_order((side, side), CPU).numpy()[: maps.count * SIDE**2]
    return np.stack([order % side + 0.5, order // side + 0.5], axis=1) / side


def folded_floor(maps: ShadowMaps, bumps: float = 0.0) -> Vpls:
    """VPLs on a floor and a wall, red and green in stripes, of normals that stray by `bumps`; some pixels are dark."""
    place, count = places(maps), maps.count * SIDE**2
    rng, vpls = np.random.default_rng(0), allocate_vpls(count, CPU)
    wall = place[:, 1] > 0.5
    x, y, z = place[:, 0], np.where(wall, place[:, 1] - 0.5, 0.0), np.where(wall, 0.5, place[:, 1])
    vpls.position = column(np.stack([x, y, z], axis=1) + rng.uniform(0.0, 1e-3, (count, 3)), wp.vec3)
    normal = np.where(wall[:, None], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]) + rng.normal(0.0, bumps, (count, 3))
    vpls.normal = column(normal / np.linalg.norm(normal, axis=1, keepdims=True), wp.vec3)
    red = (place[:, 0] * 4).astype(int) % 2 == 0
    color = np.where(red[:, None], [0.8, 0.1, 0.1], [0.1, 0.8, 0.1])
    flux = color * rng.uniform(0.5, 2.0, (count, 1)) * (rng.uniform(size=(count, 1)) > 0.1)
    vpls.flux = column(flux, wp.vec3)
    return vpls


def clustered(
    maps: ShadowMaps, vpls: Vpls, seeds: Ints, chosen: ShadowMapClusterParameters = SHADOW_MAP_CLUSTER_PARAMETERS
) -> tuple[ShadowMapClustering, KeptSeeds]:
    """One round of clusters that begin at `seeds`."""
    clustering = ShadowMapClustering(maps, len(seeds), CPU, chosen)
    kept = clustering.new_seeds()
    again(clustering, kept, vpls, seeds, begins=True)
    return clustering, kept


def again(clustering: ShadowMapClustering, kept: KeptSeeds, vpls: Vpls, seeds: Ints, *, begins: bool) -> None:
    clustering.seeds.assign(seeds.astype(np.int32))
    clustering.run(vpls, kept, begins=begins)


def owners(clustering: ShadowMapClustering) -> Ints:
    """The cluster of each pixel, −1 for none."""
    starts, items = clustering.groups.starts.numpy(), clustering.groups.items.numpy()
    found = np.full(clustering.groups.capacity, -1)
    found[items[: starts[-1]]] = np.repeat(np.arange(clustering.count), np.diff(starts))
    return found


def seeds_of(vpls: Vpls, count: int = COUNT, seed: int = 1) -> Ints:
    lit = np.flatnonzero(vpls.flux.numpy().sum(axis=1) > 0.0)
    return np.sort(np.random.default_rng(seed).choice(lit, count, replace=False))

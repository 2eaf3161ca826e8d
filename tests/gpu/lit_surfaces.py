"""VPL clusters, and the radiosity that their members know, made in one call for tests of what reads them."""

import numpy as np
import warp as wp
from scenes import box, column, grey, quad, resident_of

from gpu.clustering.grid import CLUSTERING_PARAMETERS
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.scene.types import Doubles
from gpu.vpl.build import VPL_CLUSTER_PARAMETERS, VplClusterParameters, no_clusters
from gpu.vpl.clustering import VplClustering
from gpu.vpl.group_lights import GroupLights
from gpu.vpl.radiosity_cache import RADIOSITY_PARAMETERS, RadiosityCache, RadiosityCells, RadiosityParameters
from gpu.vpl.radiosity_estimate import RadiosityBuilder
from gpu.vpl.vpl_clusters import VplClusters


def cluster_vpls(device_scene: DeviceScene, vpls: Vpls, wanted: int, seed: int,
                 chosen: VplClusterParameters = VPL_CLUSTER_PARAMETERS) -> VplClusters:  # fmt: skip
    """At most `wanted` clusters of `vpls`."""
    device, most = device_scene.device, min(wanted, vpls.count)
    if vpls.count == 0:
        return no_clusters()
    lights = GroupLights(vpls.count, most, device, chosen)
    VplClustering(vpls, wp.array([vpls.count], dtype=int, device=device), most, device).run(lights, seed)
    return lights.vpls


def radiosity_cache(device_scene: DeviceScene, scene: SceneData, clusters: VplClusters,
                    lobes: SceneFeatures | None = None,
                    chosen: RadiosityParameters = RADIOSITY_PARAMETERS) -> RadiosityCache:  # fmt: skip
    """The radiosity at the members of `clusters`, of which there is one or more, on the surfaces of `scene`.

    lobes: as for RadiosityBuilder.
    """
    builder = RadiosityBuilder(clusters, device_scene.device, chosen, lobes=lobes)
    builder.run(scene)
    return builder.cache


def joined(*parts: Vpls) -> Vpls:
    """All VPLs of some sets."""
    vpls = allocate_vpls(sum(part.count for part in parts), wp.get_device("cpu"))
    for name in ("position", "normal", "flux"):
        values = np.concatenate([getattr(part, name).numpy() for part in parts])
        setattr(vpls, name, column(values, wp.vec3))
    return vpls


def floors(heights: tuple[float, ...], half: float = 0.5) -> DeviceScene:
    """Floors that face up."""
    parts = [quad((-half, height, half), (2.0 * half, 0.0, 0.0), (0.0, 0.0, -2.0 * half)) for height in heights]
    return resident_of([*parts, *box(0)], [grey(0.5)])


def mapped(device_scene: DeviceScene, vpls: Vpls) -> RadiosityCache:
    """What 60 clusters of these VPLs at most know."""
    return radiosity_cache(device_scene, device_scene.data, cluster_vpls(device_scene, vpls, 60, 0))


def inner(lit: RadiosityCache, half: float = 0.2) -> Doubles:
    """Which VPLs lie well inside a square."""
    return (np.abs(lit.position.numpy()[:, [0, 2]]) < half).all(axis=1)


def by_hand(positions: Doubles, radius: float) -> RadiosityCache:
    """A cache of VPLs that face up, of estimates' disks of a radius."""
    count, lit = len(positions), RadiosityCache()
    lit.chosen, lit.alike = RADIOSITY_PARAMETERS, CLUSTERING_PARAMETERS
    lit.position, lit.normal = column(positions, wp.vec3), column(np.tile([0.0, 1.0, 0.0], (count, 1)), wp.vec3)
    lit.radius, lit.radiosity = column(np.full(count, radius), float), column(np.ones((count, 3)), wp.vec3)
    lit.covered = wp.zeros(count, dtype=int, device="cpu")
    RadiosityCells(lit, wp.get_device("cpu")).sort()
    return lit

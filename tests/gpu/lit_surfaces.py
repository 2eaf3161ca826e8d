"""VPL clusters, and the radiosity that their members know, made in one call for tests of what reads them."""

import warp as wp

from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls
from gpu.vpl.build import VPL_CLUSTER_PARAMETERS, VplClusterParameters, no_clusters
from gpu.vpl.clustering import VplClustering
from gpu.vpl.group_lights import GroupLights
from gpu.vpl.radiosity_cache import RADIOSITY_PARAMETERS, RadiosityBuilder, RadiosityCache, RadiosityParameters
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

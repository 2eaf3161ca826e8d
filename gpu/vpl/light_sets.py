"""The light of a scene that no camera changes: its emitters, VPLs and VPL clusters. Made once, shared by renderers."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import warp as wp

from gpu.core.device import overwrite
from gpu.device_scene.features import scene_features
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_paths import Vpls, paths_for, trace_light_paths
from gpu.lights.light_table import LightTable
from gpu.vpl.build import cluster_vpls
from gpu.vpl.radiosity_cache import RadiosityCache, radiosity_cache
from gpu.vpl.sun_importance import sun_maps_of
from gpu.vpl.vpl_clusters import VplClusters

Progress = Callable[[str, float], None]
# VPLs kept per scene, in whole sets: enough for the sets of a still view's frames, few enough to bound memory: 0.8 GB.
KEPT_VPLS = 1 << 23


@dataclass(frozen=True)
class LightSetChoice:
    """What a light set depends on besides the scene."""

    vpls: int
    vpl_clusters: int
    bounces: int
    seed: int
    lambertian: bool


class LightSets:
    """A scene's light sets by choice, and the table of its emitters."""

    def __init__(self, device_scene: DeviceScene) -> None:
        self._device_scene = device_scene
        self._sets: dict[LightSetChoice, VplClusters] = {}
        self._radiosity: dict[LightSetChoice, RadiosityCache] = {}
        # Light paths of sets that differ by their seed.
        self._paths: dict[LightSetChoice, int] = {}
        self.table: LightTable = build_light_table(device_scene)
        self.table.suns = sun_maps_of(device_scene, self.table)

    def clusters(self, choice: LightSetChoice, progress: Progress) -> VplClusters:
        """The clusters of `choice`, traced and clustered when they are not kept from before."""
        if choice in self._sets:
            self._sets[choice] = self._sets.pop(choice)
            return self._sets[choice]
        clusters = self._make(choice, progress)
        while self._sets and sum(kept.vpls for kept in self._sets) + choice.vpls > KEPT_VPLS:
            oldest = next(iter(self._sets))
            del self._sets[oldest]
            self._radiosity.pop(oldest, None)
        self._sets[choice] = clusters
        return clusters

    def holds(self, choice: LightSetChoice) -> bool:
        """Whether the clusters of `choice` are kept from before."""
        return choice in self._sets

    def retrace(self, choice: LightSetChoice, progress: Progress) -> None:
        """Make the clusters of `choice` anew, into the arrays that are kept: whoever reads those need not know."""
        if not self.holds(choice):
            self.clusters(choice, progress)
            return
        kept, made = self._sets[choice], self._make(choice, progress)
        if kept.count:
            overwrite(VplClusters, kept, made)
            overwrite(Vpls, kept.members, made.members)
            self._complete()

    def _make(self, choice: LightSetChoice, progress: Progress) -> VplClusters:
        scene = self._device_scene.view(lambertian=choice.lambertian)
        features = scene_features(self._device_scene.scene, lambertian=choice.lambertian)
        progress("tracing virtual point lights", 0.0)
        alike = replace(choice, seed=0)
        if alike not in self._paths:
            self._paths[alike] = paths_for(self._device_scene, scene, self.table, choice.vpls, choice.bounces, features)
        paths = self._paths[alike]
        vpls = trace_light_paths(self._device_scene, scene, self.table, paths, choice.bounces, choice.seed, features)
        progress("clustering virtual point lights", 0.5)
        clusters = cluster_vpls(self._device_scene, vpls, choice.vpl_clusters, choice.seed)
        progress("clustering virtual point lights", 1.0)
        self._complete()
        return clusters

    def _complete(self) -> None:
        """Whoever finds what was made may read it in another lane (gpu.core.lane)."""
        wp.synchronize_device(self._device_scene.device)

    def radiosity(self, choice: LightSetChoice, progress: Progress) -> RadiosityCache:
        """The radiosity around the VPLs of `choice`, of which there must be one; kept as long as they are."""
        clusters = self.clusters(choice, progress)
        if choice not in self._radiosity:
            self._radiosity[choice] = radiosity_cache(
                self._device_scene, self._device_scene.view(lambertian=choice.lambertian), clusters
            )
            self._complete()
        return self._radiosity[choice]

"""The lights of `rsm-disks`: clusters of reflective shadow maps, in every frame those of the lights as they are."""

from weakref import WeakKeyDictionary

import warp as wp

from gpu.core.device import alike, overwrite
from gpu.core.stages import Stages
from gpu.indirect.clustered_light import clustered_light
from gpu.indirect.polygon_shading import shade_by_polygons
from gpu.lights.importance_warp import ImportanceWarp
from gpu.lights.light_paths import allocate_vpls
from gpu.lights.reflective_shadow_map import ShadowMaps, make_shadow_maps, trace_shadow_maps
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import FrameKind, frame_seed
from gpu.methods.fuzzy_correction import FuzzyCorrection
from gpu.methods.fuzzy_view_state import FuzzyViewState, KeptLight
from gpu.methods.method import RenderSetup
from gpu.settings import Component, LightShape, RenderSettings
from gpu.vpl.bidirectional_importance import BidirectionalImportance
from gpu.vpl.build import no_clusters
from gpu.vpl.group_lights import GroupLights
from gpu.vpl.polygon_light import Polygons, allocate_polygons, fit_polygons
from gpu.vpl.radiosity_estimate import RadiosityBuilder
from gpu.vpl.shadow_map_clusters import KeptSeeds, ShadowMapClustering


def by_rays(settings: RenderSettings) -> bool:
    """Whether there are near field and corrections, which are of disks, and by rays, which the paper does without."""
    return settings.indirect_shadows and settings.light_shape is LightShape.DISKS


class RsmLights(ClusteredLights):
    """Algorithm 1 of the 2012 paper, with what it works with: arrays of the maps' size, allocated once."""

    are_kept = False
    relights = True

    def __init__(self, setup: RenderSetup, frame: FrameArrays, most: int) -> None:
        """most: SP clusters."""
        super().__init__(setup, frame)
        settings, counts, table = setup.settings, setup.sample_counts, setup.light_sets.table
        self.vpls, self.cache = no_clusters(), None
        self._kept_seeds: WeakKeyDictionary[FuzzyViewState, KeptSeeds] = WeakKeyDictionary()
        self.has_indirect = settings.component is not Component.DIRECT and table.count > 0
        self._polygons: Polygons | None = None
        self.has_near = self.has_indirect and settings.near_field and by_rays(settings)
        self.corrects = settings.correct and by_rays(settings)
        if self.has_indirect:
            self._allocate(counts.shadow_map, counts.vpl_clusters)
        self.room = min(counts.sp_clusters, most, setup.pixels), self.vpls.count
        self.correction = FuzzyCorrection(frame, 1, counts.sp_clusters, max(self.vpls.count, 1))

    def _allocate(self, side: int, clusters: int) -> None:
        setup, device = self._setup, self._setup.device
        self._maps, self._version = self._maps_of(side), setup.light_sets.version
        pixels = self._maps.count * side**2
        self._pixels = allocate_vpls(pixels, device)
        self._importance = BidirectionalImportance(device)
        self._warp = ImportanceWarp(pixels, self._maps.atlas_side, device, setup.settings.seed)
        self.clustering = ShadowMapClustering(self._maps, min(clusters, pixels), device)
        self._lights = GroupLights(pixels, self.clustering.count, device)
        self.vpls = self._lights.vpls
        if setup.settings.light_shape is LightShape.POLYGONS:
            self._polygons = allocate_polygons(self.vpls, device)
        has = self._frame.features
        lobes = has if has.reads_light else None
        self._radiosity = RadiosityBuilder(self.vpls, device, lobes=lobes) if self.has_near else None
        self.cache = self._radiosity.cache if self._radiosity else None

    def _maps_of(self, side: int) -> ShadowMaps:
        sets = self._setup.light_sets
        return make_shadow_maps(self._setup.device_scene, sets.table, sets.by_power, side)

    def follow(self, kind: FrameKind) -> bool:
        """Have maps of the lights as they are, unless there are more or fewer now."""
        sets = self._setup.light_sets
        if not self.has_indirect or self._version == sets.version:
            return True
        maps = self._maps_of(self._maps.side)
        if not alike(ShadowMaps, self._maps, maps):
            return False
        overwrite(ShadowMaps, self._maps, maps)
        self._version = sets.version
        return True

    def seeds_of(self, view: FuzzyViewState) -> KeptSeeds:
        """Where clusters of a view's walk start."""
        if view not in self._kept_seeds:
            self._kept_seeds[view] = self.clustering.new_seeds()
        return self._kept_seeds[view]

    def lit(self) -> wp.array:
        """How many pixels of the maps have light, (1,)."""
        return self.vpls.starts[self.vpls.count :]

    def choose(self, view: FuzzyViewState, kind: FrameKind, stages: Stages, *, begins: bool) -> None:
        """Trace the maps, and cluster them by one round from the seeds that the walk's last frame had, mostly.

        Frames of a walk have the same rays, so that clusters change as lights do; those of a still view have their own.
        Where an edit has changed lights, seeds are chosen by these alone.
        """
        setup, frame, pixels, seeds = self._setup, self._frame, self._pixels, self.seeds_of(view)
        settings, table = setup.settings, setup.light_sets.table
        seed = frame_seed(settings.seed, kind.sample)

        def trace() -> None:
            trace_shadow_maps(frame.scene, table, self._maps, setup.bounces, seed, frame.features, pixels)

        def cluster() -> None:
            self._importance.run(frame.gbuffer, frame.size, self._maps, pixels, self._warp.importance)
            self._warp.run(self.clustering.seeds)
            self.clustering.run(pixels, seeds, begins=begins)

        def make_lights() -> None:
            self._lights.run(pixels, self.clustering.groups, self.clustering.medoids)
            if self._radiosity:
                self._radiosity.run(frame.scene)
            if self._polygons:
                fit_polygons(self.vpls, self._polygons)

        stages.run("shadow-maps", trace, repeats=kind.captured)
        stages.run("map-clusters", cluster, repeats=kind.captured, branch=begins)
        stages.run("disks", make_lights, repeats=kind.captured)

    def reuses_clusters(self, view: FuzzyViewState, kept: KeptLight, kind: FrameKind) -> bool:
        """Whether the view's last frame was of the same walk and saw much the same, in whatever light."""
        goes_on = kind.sample == 0 and view.reuses_history and (kept.last_sample == 0 or kept.relit)
        return goes_on and self._setup.settings.skip.kept_clusters

    def trace(self, view: FuzzyViewState) -> None:
        """As others, unless nothing is to hide indirect light."""
        if self._setup.settings.indirect_shadows:
            super().trace(view)
        else:
            self.known_to(view).visibility.see_all()

    def shade(self, view: FuzzyViewState, *, few: bool) -> None:
        """As others, or by polygons."""
        if self._polygons is None:
            super().shade(view, few=few)
            return
        frame, kept, fuzziness = self._frame, self.known_to(view), self._setup.settings.fuzziness
        known = clustered_light(view.clustering.clusters, kept.visibility.words, self.vpls, kept.far.data)
        shade_by_polygons(fuzziness, frame.gbuffer, view.points, known, self._polygons, frame.indirect)

"""The VPL clusters that a frame of `fuzzy-vpl` is lit by, and arrays that have room for as many. Steps 1, 2."""

from typing import Any

import warp as wp

from gpu.core.stages import Stages
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.fuzzy_correction import Convergence, FuzzyCorrection
from gpu.methods.fuzzy_view_state import FuzzyViewState, KeptLight
from gpu.methods.method import RenderSetup
from gpu.methods.passes import STILL_VIEW_PARAMETERS, FrameKind, keeps_lights, light_set_choice
from gpu.settings import Clustering, Component
from gpu.vpl.bound_area import areas_of, bound_areas
from gpu.vpl.build import unclustered
from gpu.vpl.light_sets import LightSetChoice
from gpu.vpl.vpl_clusters import VplClusters


def frames_a_set(vpls: int) -> int:
    """How many frames of a still view a light set of so many VPLs serves."""
    return STILL_VIEW_PARAMETERS.frames_a_set if vpls >= STILL_VIEW_PARAMETERS.many_vpls else 1


class FuzzyLights(ClusteredLights):
    """Light sets of one number of VPLs and clusters of them: a walk's, and others for later frames of a still view."""

    def __init__(
        self, setup: RenderSetup, frame: FrameArrays, passes: int, most: int, lent: FuzzyCorrection | None = None
    ) -> None:
        """passes: as for FuzzyCorrection; most: SP clusters in any lights; lent: by other lights, what has the
        image's size.
        """
        super().__init__(setup, frame)
        settings, counts = setup.settings, setup.sample_counts
        # The ablation without VPL clusters keeps its VPLs: another set of them may not fit its arrays.
        self._fixed = settings.clustering is Clustering.SPS
        vpls = setup.light_sets.clusters(light_set_choice(setup), setup.progress)
        # Captured graphs read the arrays of this set, so it must live as long as they do.
        self.vpls = self._first = unclustered(setup.device_scene, vpls) if self._fixed else vpls
        self.has_indirect = settings.component is not Component.DIRECT and vpls.count > 0
        self.has_near = self.has_indirect and settings.near_field
        self.cache = self._first_cache = self._cache_of(light_set_choice(setup))
        self.corrects = settings.correct
        vpl_clusters = self._first.count if self._fixed else counts.vpl_clusters
        self.room = min(counts.sp_clusters, most, setup.pixels), vpl_clusters
        self._bounded: VplClusters | None = None
        self._areas: wp.array = None
        self.correction = FuzzyCorrection(frame, passes, counts.sp_clusters, vpl_clusters, lent)

    def choose(self, view: FuzzyViewState, kind: FrameKind, stages: Stages) -> None:
        """Have in `vpls` and `cache` those of a frame, which are mostly kept from before."""
        setup, number = self._setup, self._number_of(kind.sample)
        choice = light_set_choice(setup, number)
        self.are_kept = keeps_lights(setup, choice, stages, held=number == 0)
        self.vpls, self.cache = self._first, self._first_cache
        if number > 0:
            self.vpls, self.cache = setup.light_sets.clusters(choice, setup.progress), self._cache_of(choice)

    def _cache_of(self, choice: LightSetChoice) -> Any:
        return self._setup.light_sets.radiosity(choice, self._setup.progress) if self.has_near else None

    def _number_of(self, sample: int) -> int:
        """The number of the light set of frame `sample` of a still view."""
        return 0 if self._fixed else sample // frames_a_set(self._setup.sample_counts.vpls)

    def convergence(self, kind: FrameKind) -> Convergence | None:
        """As for other lights; bounds are read from the first set, which lights none of these frames."""
        settings = self._setup.settings
        if not (kind.refines and self.has_near and self.corrects):
            return None
        bounds = bound_areas(self._first_cache)
        if self._bounded is not self.vpls:
            self._bounded, self._areas = self.vpls, areas_of(self.vpls, bounds)
        table = self._setup.light_sets.table
        return Convergence(table, self.vpls, bounds, self._areas, settings.bounces, settings.seed)

    def reuses_clusters(self, view: FuzzyViewState, kept: KeptLight, kind: FrameKind) -> bool:
        """Whether the last frame's clusters are of this one's lights, and it sees much the same.

        Of a still view's frames the smoothed ones and the first of each light set of many VPLs begin from nothing.
        """
        sample, last = kind.sample, kept.last_sample
        if not (self.are_kept and self._setup.settings.skip.kept_clusters):
            return False
        if sample == 0:
            return last == 0 and view.reuses_history
        begins = not kind.refines or sample % STILL_VIEW_PARAMETERS.frames_a_set == 0
        follows = view.is_still and last == sample - 1 and not begins
        return follows and self._number_of(sample - 1) == self._number_of(sample)

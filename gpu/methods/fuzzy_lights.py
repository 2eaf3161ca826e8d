"""The VPL clusters that a frame of `fuzzy-vpl` is lit by, and arrays that have room for as many. Steps 1, 2."""

import warp as wp

from gpu.core.stages import Stages
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import STILL_VIEW_PARAMETERS, FrameKind
from gpu.methods.fuzzy_correction import Convergence, FuzzyCorrection
from gpu.methods.fuzzy_view_state import FuzzyViewState, KeptLight
from gpu.methods.light_making import keeps_lights, light_set_choice, make_lights
from gpu.methods.method import RenderSetup
from gpu.settings import Clustering, Component
from gpu.vpl.bound_area import areas_of, bound_areas
from gpu.vpl.build import unclustered
from gpu.vpl.light_set import LightSet
from gpu.vpl.vpl_lobes import lobes_of, no_lobes


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
        # Captured graphs read the arrays of this set, so it must live as long as they do.
        self._first = setup.light_sets.made(light_set_choice(setup), setup.progress)
        self._singles = unclustered(setup.device_scene, self._first.clusters) if self._fixed else None
        self._use(self._first)
        self.corrects = settings.correct
        vpl_clusters = self.vpls.count if self._fixed else counts.vpl_clusters
        self.room = min(counts.sp_clusters, most, setup.pixels), vpl_clusters
        self._bounded: tuple[LightSet, int] | None = None
        self._areas: wp.array = None
        self._lobes = no_lobes()
        self.correction = FuzzyCorrection(frame, passes, counts.sp_clusters, vpl_clusters, lent)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Of these arrays and those of the walk's light set."""
        return self.number, *self._first.numbers

    def follow(self, kind: FrameKind) -> bool:
        """Find the frame's light set, and whether it is kept from before. VPLs that are not clustered are others in
        number when light has changed.
        """
        setup, number = self._setup, self._number_of(kind.sample)
        if setup.settings.component is Component.DIRECT:
            return True
        if self._fixed and not setup.light_sets.is_current(self._first):
            return False
        light_set = self._first if number == 0 else setup.light_sets.at(light_set_choice(setup, number))
        self.are_kept = keeps_lights(setup, light_set)
        self.are_late = not self.are_kept
        if self.are_kept:
            self._use(light_set)
        else:
            self._used, self.has_indirect = light_set, True
        return True

    def choose(self, view: FuzzyViewState, kind: FrameKind, stages: Stages, *, begins: bool) -> None:
        """Make the light set that `follow` has found, unless it is kept."""
        if not self.are_kept:
            make_lights(self._setup, self._used, stages, captured=kind.captured)
            self._use(self._used)

    def _use(self, light_set: LightSet) -> None:
        settings = self._setup.settings
        self._used, self.vpls = light_set, self._singles or light_set.clusters
        self.has_indirect = settings.component is not Component.DIRECT and light_set.count > 0
        self.has_near = self.has_indirect and settings.near_field
        self.converges = self.has_near and settings.correct and self._first.count > 0
        self.cache = self._setup.light_sets.radiosity(light_set) if self.has_near else None

    def _number_of(self, sample: int) -> int:
        """The number of the light set of frame `sample` of a still view."""
        return 0 if self._fixed else sample // frames_a_set(self._setup.sample_counts.vpls)

    def convergence(self, kind: FrameKind) -> Convergence | None:
        """As for other lights; bounds are read from the first set, which lights none of these and may be empty."""
        settings = self._setup.settings
        if not (kind.refines and self.converges):
            return None
        sets, known = self._setup.light_sets, (self._used, self._used.version)
        if not sets.is_current(self._first):
            sets.renew(self._first, self._setup.progress)
        bounds = bound_areas(sets.radiosity(self._first))
        if self._bounded != known:
            self._bounded, self._areas = known, areas_of(self.vpls, bounds)
            self._lobes = lobes_of(self._frame.scene, self._frame.features, self.vpls.members)
        table = sets.table
        return Convergence(table, self.vpls, self._lobes, bounds, self._areas, self._setup.bounces, settings.seed)

    def reuses_clusters(self, view: FuzzyViewState, kept: KeptLight, kind: FrameKind) -> bool:
        """Whether the last frame's clusters are of this one's lights, or see others now, and it sees much the same.

        Of a still view's frames the smoothed ones and the first of each light set of many VPLs begin from nothing.
        """
        sample, last = kind.sample, kept.last_sample
        if not self._setup.settings.skip.kept_clusters:
            return False
        if not self.are_kept:
            return sample == 0 and kept.relit and view.reuses_history
        if sample == 0:
            return last == 0 and view.reuses_history
        begins = not kind.refines or sample % STILL_VIEW_PARAMETERS.frames_a_set == 0
        follows = view.is_still and last == sample - 1 and not begins
        return follows and self._number_of(sample - 1) == self._number_of(sample)

"""`fuzzy-vpl`: clustered VPLs and SPs with fuzzy visibility, the 2022 paper's method."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import Any
from weakref import WeakSet

from gpu.core.stages import Stages, new_number
from gpu.gbuffer.sparse_shading import stride_of
from gpu.indirect.far_field import FarSums
from gpu.indirect.fuzzy_shading import shade
from gpu.indirect.visibility import Visibility
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.fuzzy_correction import FuzzyCorrection
from gpu.methods.fuzzy_statistics import NOTHING, FuzzyCounter
from gpu.methods.fuzzy_view import FuzzyView, KeptLight
from gpu.methods.method import FrameStatistics, RenderMethod, RenderSetup
from gpu.methods.passes import FrameKind, Passes, frame_kind, frame_seed, keeps_lights, light_set_choice
from gpu.sample_counts import SampleCounts
from gpu.settings import Clustering, Component, Weighting
from gpu.sp.sp_clustering import SpClustering
from gpu.vpl.build import unclustered
from gpu.vpl.light_sets import LightSetChoice
from gpu.vpl.vpl_clusters import VplClusters

# Frames of a still view that a light set of many VPLs serves: making it takes as long as such a frame, and sets differ
# by little beside the noise of the SPs' own rays. Those of few VPLs differ much and are soon made.
FRAMES_A_SET, MANY_VPLS = 4, 1 << 16


@dataclass(frozen=True)
class FuzzyOptions:
    """What those who choose counts from frame to frame ask for (gpu.methods.targeted).

    most_sp_clusters: there is room for, 0: as many as the sample counts say; passes: there may be of SPs' rays;
    keeps_light: whether light of frames before is built on; inspect: what looks at the indirect light of a first frame
    of a view, all of whose VPL clusters it gets, before near-field light is added.
    """

    most_sp_clusters: int = 0
    passes: int = 1
    keeps_light: bool = True
    inspect: Callable[[FuzzyView, FrameArrays, VplClusters, Stages], None] | None = None


class FuzzyVpl(RenderMethod[FuzzyView]):
    """The six steps of the 2022 paper, section 3.1; steps 1 and 2 happened when the light set was made."""

    stage_names = ("light", "gbuffer", "history", "cluster", "visibility", "shade", "correct", "refine", "bright",
                   "probe", "direct", "near", "interpolate", "keep")  # fmt: skip
    pixel_bytes, view_pixel_bytes = 580, 82

    @staticmethod
    def cluster_bytes(sample_counts: SampleCounts) -> tuple[int, int]:
        """By SP clusters, and by pairs of these and VPL clusters: fitted to the arrays of renderers of many counts."""
        clusters, vpl_clusters = sample_counts.sp_clusters, sample_counts.vpl_clusters
        return clusters * (5100 + 5 * vpl_clusters), clusters * (720 + 5 * vpl_clusters // 4)

    def __init__(self, setup: RenderSetup, options: FuzzyOptions | None = None) -> None:
        """With as many SP clusters as the sample counts tell, or fewer (`set_counts`)."""
        settings = setup.settings
        self._options = options or FuzzyOptions()
        # The ablation without VPL clusters keeps its VPLs: another set of them may not fit its arrays.
        self._fixed = settings.clustering is Clustering.SPS
        stride = stride_of(setup.pixels) if settings.skip.interpolated else 1
        self._frame = FrameArrays(
            setup.device_scene, setup.size, lambertian=settings.lambertian, skip=settings.skip, stride=stride
        )
        self._passes = Passes(setup, self._frame)
        self._most = self._options.most_sp_clusters or setup.sample_counts.sp_clusters
        self._views: WeakSet[FuzzyView] = WeakSet()
        self._counter = FuzzyCounter(setup.device)
        self._use_light_set(setup, None)

    def with_light_set(self, sample_counts: SampleCounts) -> "FuzzyVpl":
        """The method with other lights, and as many SP clusters as `sample_counts` tell, or fewer.

        Both share these, and the arrays of the image's size: render with one after the other.
        """
        other = copy(self)
        other._use_light_set(replace(self._setup, sample_counts=sample_counts), self._correction)
        return other

    def _use_light_set(self, setup: RenderSetup, shared: FuzzyCorrection | None) -> None:
        settings = setup.settings
        self._setup, self.number = setup, new_number()
        vpls = setup.light_sets.clusters(light_set_choice(setup), setup.progress)
        # Captured graphs read the arrays of this set, so it must live as long as they do.
        self._vpls = self._first = unclustered(setup.device_scene, vpls) if self._fixed else vpls
        self._has_indirect = settings.component is not Component.DIRECT and vpls.count > 0
        self._has_near = self._has_indirect and settings.near_field
        self._first_cache = self._cache(light_set_choice(setup))
        self._keeps_lights = True
        self._counts_in_use: tuple[int, float] | None = None
        counts = setup.sample_counts
        vpl_clusters = self._first.count if self._fixed else counts.vpl_clusters
        self._room = min(counts.sp_clusters, self._most, setup.pixels), vpl_clusters
        room = counts.sp_clusters, vpl_clusters
        self._correction = FuzzyCorrection(self._frame, self._options.passes, *room, shared)

    def new_view(self, kind: type[Any] = FuzzyView) -> Any:
        """A walk, of a `kind` of FuzzyView, that has seen nothing yet."""
        settings, points = self._setup.settings, self._frame.shading_points
        by_distance = settings.weighting is Weighting.DISTANCE
        clustering = partial(SpClustering, points, self._most, settings.fuzziness, by_distance=by_distance)
        view = kind(self._frame, clustering, next(iter(self._views), None))
        self._views.add(view)
        return view

    def kept_light(self, view: FuzzyView) -> KeptLight:
        """What a view's representatives know of these lights."""
        if self not in view.lights:
            other = next((other.lights[self] for other in self._views if self in other.lights), None)
            view.lights[self] = other.for_another_viewer() if other else self._new_light()
        return view.lights[self]

    def _new_light(self) -> KeptLight:
        skip, device = self._setup.settings.skip, self._setup.device
        far = FarSums(*self._room, device, enabled=skip.far_field_sums)
        return KeptLight(Visibility(*self._room, device, skip), far)

    def begin_anew(self, view: FuzzyView) -> None:
        """Have the view's next frame build on no clusters of frames before."""
        self.kept_light(view).last_sample = None

    def set_counts(self, sp_clusters: int, passes: float) -> None:
        """Have as many rays of single SPs as suit so many SP clusters, and `passes` of those of all in the mean.

        Raises ValueError where clusters are more than the sample counts told: arrays have no room for them.
        """
        most = self._setup.sample_counts.sp_clusters
        if sp_clusters > most:
            raise ValueError(f"{sp_clusters} SP clusters where there is room for {most}")
        if self._counts_in_use != (sp_clusters, passes):
            self._correction.use(sp_clusters, passes)
            self._counts_in_use = sp_clusters, passes

    def render(self, view: FuzzyView, stages: Stages, sample: int) -> None:
        """Direct light beside steps 3 to 6; then both are added, and the walk's next frame finds what it may keep."""
        stages.graph_key = view.number, self.number
        kind = frame_kind(self._setup.settings, view, sample)
        self._passes.begin(view, view.points, kind, stages, view.histories)
        if self._has_indirect:
            self._find_indirect(view, kind, stages)
            if self._options.inspect and kind.captured:
                self._options.inspect(view, self._frame, self._vpls, stages)
        self._passes.end_direct(view, kind, stages)
        if self._has_indirect:
            self._passes.end_indirect(view, view.points, kind, stages, near=self._has_near)
        if kind.write_history:
            stages.run("keep", partial(self._keep, view))
            view.wrote_history = True

    def _find_indirect(self, view: FuzzyView, kind: FrameKind, stages: Stages) -> None:
        """The 2022 paper's section 3.1, with near-field light and corrections by rays of single SPs beyond it."""
        frame, settings, clustering, points = self._frame, self._setup.settings, view.clustering, view.points
        history, captured = view.histories.indirect, kind.captured
        # Steps 1 and 2: VPLs and their clusters, mostly kept from before.
        (vpls, cache), kept = self._light_set(kind, stages), self.kept_light(view)
        goes_on, reads = self._goes_on(view, kept, kind), self._options.keeps_light and kind.read_history
        kept.last_sample, kept.reads_history = None, reads  # should this frame fail, it leaves nothing
        kept.corrected = settings.correct and kind.denoise
        frame.seed.fill_(kind.seed)
        if kind.denoise:
            find = partial(history.find, frame.gbuffer, points, view.histories.previous, frame.seed)
            stages.run("history", find if reads else history.forget, repeats=captured, branch=reads)
        if self._has_near:
            self._passes.begin_near(points, vpls, cache, kind, stages, history)

        # Step 4: SPs, found by the primary rays (step 3), are clustered.
        def cluster() -> None:
            if goes_on:
                clustering.go_on(frame.gbuffer, view.camera, frame.size)
            else:
                clustering.run(frame.gbuffer, frame_seed(settings.seed, kind.sample))

        # Step 5: visibility between the clusters' representatives.
        def trace() -> None:
            kept.visibility.trace(frame.scene, clustering.clusters, vpls)

        # Step 6: every SP is shaded by all VPL clusters.
        def shade_points() -> None:
            light = clustering.clusters, kept.visibility, vpls, kept.far.data
            kept.far.run(clustering.clusters, kept.visibility.words, vpls, few=goes_on)
            shade(settings.fuzziness, frame.gbuffer, points, *light, frame.seed, frame.indirect)
            if kind.denoise:
                self._correction.remember(view)

        stages.run("cluster", cluster, repeats=captured, branch=goes_on)
        stages.run("visibility", trace, repeats=captured)
        kept.last_sample = kind.sample
        stages.run("shade", shade_points, repeats=captured, branch=goes_on)
        if self._has_near:
            self._passes.share_near(points, self._correction.clustered_irradiance, kind, stages, history)
        if settings.correct:
            self._correction.run(view, kept, vpls, kind, stages)

    def _light_set(self, kind: FrameKind, stages: Stages) -> tuple[VplClusters, Any]:
        """The lights of this frame, and the radiosity around them (RadiosityCache) if near-field light is wanted."""
        setup, number = self._setup, self._set_number(kind.sample)
        choice = light_set_choice(setup, number)
        self._keeps_lights = keeps_lights(setup, choice, stages, held=number == 0)
        if number == 0:
            self._vpls = self._first
            return self._vpls, self._first_cache
        self._vpls = setup.light_sets.clusters(choice, setup.progress)
        return self._vpls, self._cache(choice)

    def _cache(self, choice: LightSetChoice) -> Any:
        return self._setup.light_sets.radiosity(choice, self._setup.progress) if self._has_near else None

    def _set_number(self, sample: int) -> int:
        """The number of the light set of frame `sample` of a still view."""
        many = self._setup.sample_counts.vpls >= MANY_VPLS
        return 0 if self._fixed else sample // (FRAMES_A_SET if many else 1)

    def _goes_on(self, view: FuzzyView, kept: KeptLight, kind: FrameKind) -> bool:
        """Whether the last frame's clusters are of this one's lights, and it sees much the same.

        Of a still view's frames the smoothed ones and every FRAMES_A_SET-th begin from nothing.
        """
        sample, last = kind.sample, kept.last_sample
        if not (self._keeps_lights and self._setup.settings.skip.kept_clusters):
            return False
        if sample == 0:
            return last == 0 and view.reuses_history
        follows = view.is_still and last == sample - 1 and kind.refines and sample % FRAMES_A_SET != 0
        return follows and self._set_number(sample - 1) == self._set_number(sample)

    def _keep(self, view: FuzzyView) -> None:
        if self._has_indirect and self._options.keeps_light:
            view.histories.indirect.keep(view.points)
        view.histories.previous.keep(self._frame.gbuffer, view.camera)

    def count(self, view: FuzzyView) -> None:
        """Sum up what the stages left, and count the pixels that see nothing."""
        if self._has_indirect:
            near = self._passes.near_field.found
            self._counter.run(self._frame, view, self.kept_light(view), self._correction, near)
        else:
            self._counter.run_direct(self._frame)

    def statistics(self, view: FuzzyView) -> FrameStatistics:
        """VPLs, clusters, SPs, those with more rays, rays of clusters, finds near field, and unserved SPs."""
        vpls = self._vpls.members.count if self._vpls.count else 0
        counts = {"vpls": vpls, "vpl_clusters": self._vpls.count, "sp_clusters": view.clustering.count}
        if not self._has_indirect:
            return counts | NOTHING | {"empty": self._counter.empty()}, self._passes.skips()
        totals, kept = self._counter.totals(), self.kept_light(view)
        skips = self._passes.skips() | {"unchanged_lights": vpls if self._keeps_lights else 0}
        skips |= totals.skips(self._setup.pixels, self._vpls.count, reads_history=kept.reads_history)
        return counts | totals.counts(corrected=kept.corrected), skips

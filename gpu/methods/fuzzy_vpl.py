"""`fuzzy-vpl`: clustered VPLs and SPs with fuzzy visibility, the 2022 paper's method."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar
from weakref import WeakSet

from gpu.core.stages import Stages
from gpu.gbuffer.sparse_shading import stride_of
from gpu.indirect.irradiance import CHECKS
from gpu.methods.caustics import caustics_of
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import STILL_VIEW_PARAMETERS, FrameKind, frame_kind, frame_seed, leaves_history
from gpu.methods.fuzzy_correction import Convergence
from gpu.methods.fuzzy_lights import FuzzyLights
from gpu.methods.fuzzy_statistics import FuzzyCounter
from gpu.methods.fuzzy_view_state import FuzzyViewState
from gpu.methods.method import FrameStatistics, RenderMethod, RenderSetup
from gpu.methods.passes import Passes, traces_lobes
from gpu.sample_counts import SampleCounts
from gpu.settings import RenderSettings, Weighting
from gpu.sp.sp_clustering import SpClustering
from gpu.vpl.vpl_clusters import VplClusters


@dataclass(frozen=True)
class FuzzyOptions:
    """What those who choose counts from frame to frame ask for (gpu.methods.targeted_vpl).

    most_sp_clusters: there is room for, 0: as many as the sample counts say; passes: there may be of SPs' rays;
    keeps_light: whether light of frames before is built on; inspect: looks at the indirect light of a first frame of a
    view, of all these VPL clusters, before near-field light is added.
    """

    most_sp_clusters: int = 0
    passes: int = 1
    keeps_light: bool = True
    inspect: Callable[[FuzzyViewState, FrameArrays, VplClusters, Stages], None] | None = None


class FuzzyVpl(RenderMethod[FuzzyViewState]):
    """The six steps of the 2022 paper, section 3.1. lights: those of the next frame."""

    stage_names: ClassVar[tuple[str, ...]] = (
        "gbuffer", "caustic-photons", "history", "cluster", "pilot", "portals", "light", "vpl-clusters", "radiosity",
        "relight", "visibility", "shade", "correct", "refine", "bright", "connect", "paths", "probe", "direct",
        "caustics", "near", "interpolate", "gloss", "branches", "antialias", "keep",
    )  # fmt: skip
    pixel_bytes, view_pixel_bytes, soft_view_pixel_bytes = 616, 82, 16
    gloss_pixel_bytes, gloss_view_pixel_bytes, branches_pixel_bytes = 57, 16, 12
    tint_pixel_bytes = 12 * CHECKS

    @staticmethod
    def cluster_bytes(sample_counts: SampleCounts) -> tuple[int, int]:
        """By SP clusters, and by pairs of these and VPL clusters: fitted to the arrays of renderers of many counts."""
        clusters, vpl_clusters = sample_counts.sp_clusters, sample_counts.vpl_clusters
        return clusters * (5264 + 5 * vpl_clusters), clusters * (720 + 5 * vpl_clusters // 4)

    @staticmethod
    def traces_lobes(settings: RenderSettings) -> bool:
        """As gpu.methods.passes.traces_lobes tells."""
        return traces_lobes(settings)

    def __init__(self, setup: RenderSetup, options: FuzzyOptions | None = None) -> None:
        settings, self._setup, self._options = setup.settings, setup, options or FuzzyOptions()
        stride = stride_of(setup.pixels) if settings.skip.interpolated else 1
        self._frame = FrameArrays(
            setup.device_scene,
            setup.size,
            lambertian=settings.lambertian,
            skip=settings.skip,
            stride=stride,
            traces_lobes=self.traces_lobes(settings),
        )
        self._passes = Passes(setup, self._frame)
        self._caustics = caustics_of(setup, self._frame)
        self._most = self._options.most_sp_clusters or setup.sample_counts.sp_clusters
        self._views: WeakSet[FuzzyViewState] = WeakSet()
        self._counter = FuzzyCounter(setup.device)
        self.lights = self._first_lights()

    def _first_lights(self) -> ClusteredLights:
        return FuzzyLights(self._setup, self._frame, self._options.passes, self._most)

    def make_lights(self, sample_counts: SampleCounts) -> ClusteredLights:
        """Lights for other counts of VPLs and clusters, and at most as many SP clusters."""
        setup = replace(self._setup, sample_counts=sample_counts)
        return FuzzyLights(setup, self._frame, self._options.passes, self._most, self.lights.correction)

    def new_view(self, kind: type[Any] = FuzzyViewState) -> Any:
        """A walk, of a `kind` of FuzzyViewState, that has seen nothing yet."""
        points, settings = self._frame.shading_points, self._setup.settings
        by_distance = settings.weighting is Weighting.DISTANCE
        clustering = partial(SpClustering, points, self._most, settings.fuzziness, by_distance=by_distance)
        # A wanted error is that of a frame alone.
        antialiases = settings.antialias and leaves_history(settings) and self._options.keeps_light
        return kind(self._frame, self._views, clustering, antialiases=antialiases)

    def render(self, view: FuzzyViewState, stages: Stages, sample: int) -> None:
        """Direct light beside steps 3 to 6; then both are added, and the walk's next frame finds what it may keep."""
        kind = frame_kind(self._setup.settings, view, sample)
        if not self.lights.follow(kind):
            self.lights = self._first_lights()
        lights = self.lights
        stages.graph_key = view.number, lights.number
        self._passes.begin(view, view.points, kind, stages)
        if self._caustics:
            self._caustics.begin(view.points, kind, stages)
        self._passes.begin_direct(view, kind, stages, view.histories)
        if lights.has_indirect:
            self._find_indirect(view, kind, stages)
        else:
            self._passes.begin_gloss(view, None, kind, stages, view.histories)
        if lights.has_indirect and self._options.inspect and kind.captured:
            self._options.inspect(view, self._frame, lights.vpls, stages)
        if self._caustics and not lights.has_indirect:
            self._caustics.fill(view.points, kind, stages)
        self._passes.end_direct(view, kind, stages)
        if self._caustics:
            self._caustics.end(view, kind, stages)
        if lights.has_indirect:
            self._passes.end_indirect(view, view.points, kind, stages, near=lights.known_to(view).near)
        self._passes.end_gloss(view, lights.cache, kind, stages)
        if kind.write_history:
            if view.antialiases:
                reads = kind.read_history
                antialias = partial(view.antialias, self._frame.gbuffer, read_history=reads)
                stages.run("antialias", antialias, branch=reads)
            light = lights.has_indirect and self._options.keeps_light
            stages.run("keep", partial(view.keep, self._frame.gbuffer, light=light))
            view.wrote_history = True

    def weight(self, sample: int) -> float:
        """More for smoothed frames where others have more noise, for less error that stays."""
        smoothed = sample < STILL_VIEW_PARAMETERS.smoothed_frames
        return STILL_VIEW_PARAMETERS.smoothed_weight if smoothed and self.lights.converges else 1.0

    def _find_indirect(self, view: FuzzyViewState, kind: FrameKind, stages: Stages) -> None:
        """The paper's steps, with near-field light and corrections by rays of single SPs beyond it."""
        frame, settings, lights, passes = self._frame, self._setup.settings, self.lights, self._passes
        clustering, points, history, captured = view.clustering, view.points, view.histories.indirect, kind.captured
        lights.check_room(clustering.count)
        clustering.spread(1 if kind.shades_all else points.stride)
        kept = lights.known_to(view)
        reuses, reads = lights.reuses_clusters(view, kept, kind), self._options.keeps_light and kind.read_history
        # Clusters that are kept in other light are where they were, but know nothing of it.
        relights, begins = lights.relights or not lights.are_kept, kept.relit or not reuses
        kept.begin(reads_history=reads, corrected=lights.corrects and kind.denoise)

        def cluster() -> None:
            if reuses:
                clustering.go_on(frame.gbuffer, view.camera, frame.size, relit=relights)
            else:
                clustering.run(frame.gbuffer, frame_seed(settings.seed, kind.sample))

        def shade_points() -> None:
            lights.shade(view, few=reuses and not relights)
            if kind.denoise:
                lights.correction.remember(view)

        # Step 3 was the primary rays. Step 4: SPs are clustered. Step 5: visibility between representatives. Step 6:
        # every SP is shaded.
        if kind.denoise:
            find = partial(history.find, frame.gbuffer, points, view.histories.previous, frame.seed)
            stages.run("history", find if reads else history.forget, repeats=captured, branch=reads)
        convergence = None if lights.are_late else self._choose_lights(view, kind, stages, begins=begins)
        stages.run("cluster", cluster, repeats=captured, branch=(reuses, relights))
        if lights.are_late:
            convergence = self._choose_lights(view, kind, stages, begins=begins)
        if not lights.has_indirect:
            return
        stages.run("visibility", partial(lights.trace, view), repeats=captured)
        kept.last_sample = kind.sample
        stages.run("shade", shade_points, repeats=captured, branch=(reuses, relights))
        if self._caustics:
            self._caustics.fill(points, kind, stages)
        if convergence is not None:
            lights.correction.converge(view, kept, convergence, kind, stages)
            return
        if kept.near:
            passes.share_near(points, lights.correction.clustered_irradiance, kind, stages, history)
        if lights.corrects:
            lights.correction.run(view, kept, lights.vpls, kind, stages)

    def _choose_lights(self, view: FuzzyViewState, kind: FrameKind, stages: Stages, *,
                       begins: bool) -> Convergence | None:  # fmt: skip
        """Steps 1 and 2: VPLs and their clusters, mostly kept from before. Begin with what rays find of them."""
        lights, passes, points, histories = self.lights, self._passes, view.points, view.histories
        lights.choose(view, kind, stages, begins=begins)
        stages.graph_key = view.number, *lights.numbers
        convergence, kept = lights.convergence(kind), lights.known_to(view)
        kept.near = lights.has_near and convergence is None
        passes.begin_gloss(view, lights.cache, kind, stages, histories)
        if kept.near:
            passes.begin_near(points, lights.vpls, lights.cache, kind, stages, histories.indirect)
        return convergence

    def count(self, view: FuzzyViewState) -> None:
        """Sum up what the stages left, and count the pixels that see nothing."""
        self._counter.run(self._frame, view, self.lights, self._passes.near_field.found)
        if self._caustics:
            self._caustics.count()

    def statistics(self, view: FuzzyViewState) -> FrameStatistics:
        """VPLs, clusters, SPs, those with more rays, rays of clusters, finds near field, and unserved SPs."""
        counts, skips = self._counter.statistics(view, self.lights, self._passes)
        return counts | (self._caustics.counts() if self._caustics else {}), skips
